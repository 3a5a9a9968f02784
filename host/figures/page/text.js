// SPDX-License-Identifier: Apache-2.0

// Elements, texts with subscripts, numbers, and data as CSV.

const svgSpace = "http://www.w3.org/2000/svg";

function fill(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key === "style") node.style.cssText = value;
    else if (value !== undefined && value !== null) node.setAttribute(key, value);
  }
  for (const child of children.flat()) node.append(child);
  return node;
}
function svg(name, attributes, ...children) { return fill(document.createElementNS(svgSpace, name), attributes, children); }
function html(name, attributes, ...children) { return fill(document.createElement(name), attributes, children); }
const ink = name => `var(--${name})`;

// Pieces of "τ_{xy}" and "σ_y": text and whether it stands low or high. A backslash makes the next character plain.
function pieces(text) {
  const out = [];
  const add = (piece, place) => {
    const last = out[out.length - 1];
    if (last && last.place === place) last.text += piece; else out.push({ text: piece, place });
  };
  for (let i = 0; i < text.length; ++i) {
    const place = text[i] === "_" ? "sub" : text[i] === "^" ? "sup" : "";
    if (text[i] === "\\" && i + 1 < text.length) add(text[++i], "");
    else if (place && text[i + 1] === "{" && text.indexOf("}", i) > 0) {
      const end = text.indexOf("}", i);
      add(text.slice(i + 2, end), place);
      i = end;
    } else if (place && i + 1 < text.length) add(text[++i], place);
    else add(text[i], "");
  }
  return out;
}
function plainText(text) { return pieces(text).map(p => (p.place === "sub" ? "_" : p.place === "sup" ? "^" : "") + p.text).join(""); }
function richHtml(text) { return pieces(text).map(p => p.place ? html(p.place, {}, p.text) : p.text); }
// Text of an SVG. Baselines are moved by dy, which every browser knows.
function svgText(x, y, text, attributes) {
  const node = svg("text", { x, y, ...attributes });
  let low = 0;
  for (const piece of pieces(String(text))) {
    const level = piece.place === "sub" ? 3 : piece.place === "sup" ? -4 : 0;
    node.append(svg("tspan", { dy: level - low, "font-size": piece.place ? "0.8em" : null }, piece.text));
    low = level;
  }
  return node;
}

// A number as people read it: `digits` significant ones, powers of ten beyond a few zeros.
function number(value, digits = 4) {
  if (value === null || value === undefined || !isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size < 1e-3 || size >= 1e6 ? value.toExponential(Math.max(0, digits - 2)) : String(parseFloat(value.toPrecision(digits)));
  return text.replace("-", "−").replace("e−", "e-").replace("e+", "e");
}
const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1").replace("-", "−");

function csvText(rows) {
  const cell = value => {
    const text = value === null || value === undefined ? "" : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map(row => row.map(cell).join(",")).join("\n") + "\n";
}
// A button that saves what `rows` returns.
function csvButton(label, name, rows) {
  const button = html("button", { type: "button", title: `Save ${name}.csv` }, label);
  button.addEventListener("click", () => {
    const link = html("a", { href: URL.createObjectURL(new Blob([csvText(rows())], { type: "text/csv" })), download: name + ".csv" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  return button;
}

// One box that follows the pointer.
const tip = html("div", { class: "tip", hidden: "" });
function showTip(event, lines) {
  tip.replaceChildren(...lines.flatMap((line, i) => [...(i ? [html("br")] : []), ...richHtml(line)]));
  tip.hidden = false;
  const left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8);
  const over = event.clientY + 18 + tip.offsetHeight > innerHeight;
  tip.style.left = Math.max(4, left) + "px";
  tip.style.top = (over ? event.clientY - tip.offsetHeight - 12 : event.clientY + 18) + "px";
}
const hideTip = () => { tip.hidden = true; };
