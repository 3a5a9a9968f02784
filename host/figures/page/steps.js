// SPDX-License-Identifier: Apache-2.0

// What contacts over their load steps share: slider and play button, status of places, arrows, tractions along a line.

const statusInk = { o: "grey", t: "green", l: "red" };  // open, stick, slip
const statusMark = { o: "circles", t: "circles", l: "triangles" };
const statusWord = { o: "open", t: "stick", l: "slip" };
function statusLegend(shown = "tlo") {
  const sample = each => svg("svg", { width: 14, height: 12 }, each === "o" ? markNode("circles", 7, 6, 2.6, "none", { stroke: ink("grey") }) : markNode(statusMark[each], 7, 6, 3.8, ink(statusInk[each])));
  return html("div", { class: "legend" }, ...[...shown].map(each => html("span", {}, sample(each), statusWord[each])));
}

// Paths of an arrow's shaft and head, in pixels; null where it is too short to see.
function arrowPaths(x1, y1, x2, y2, most = 9, least = 2.5) {
  const size = Math.hypot(x2 - x1, y2 - y1);
  if (size < least) return null;
  const [dx, dy] = [(x2 - x1) / size, (y2 - y1) / size], head = Math.min(most, size), bx = x2 - head * dx, by = y2 - head * dy;
  const at = (x, y) => `${x.toFixed(1)},${y.toFixed(1)}`;
  return { shaft: `M${at(x1, y1)}L${at(bx, by)}`, head: `M${at(x2, y2)}L${at(bx - 0.55 * head * dy, by + 0.55 * head * dx)}L${at(bx + 0.55 * head * dy, by - 0.55 * head * dx)}Z` };
}
function forceArrow(x1, y1, x2, y2, colour) {
  const paths = arrowPaths(x1, y1, x2, y2);
  return paths ? [svg("path", { d: paths.shaft, stroke: ink(colour), "stroke-width": 3.4 }), svg("path", { d: paths.head, fill: ink(colour) })] : [];
}

// A series of values at places x; with `widths` constant on each, and 0 beyond the ends.
function along(label, x, widths, values, colour, mark) {
  const s = { label, mark, ink: colour, x: [], y: [], low: [], high: [] };
  x.forEach((at, k) => {
    if (!widths) { s.x.push(at); s.y.push(values[k]); return; }
    const half = widths[k] / 2;
    if (k === 0) { s.x.push(at - half); s.y.push(0); }
    s.x.push(at - half, at + half);
    s.y.push(values[k], values[k]);
    if (k === x.length - 1) { s.x.push(at + half); s.y.push(0); }
  });
  return s;
}

// Tractions along a line: `lines`, the first of which is the pressure, and marks of status on the `marked` values.
function tractionPanel({ title, x_label, y_label, x_range, y_range, width, height = 220, left, right }, lines, x, marked, status) {
  const panel = { title, x_label, y_label, series: lines, x_ticks: [], x_range, y_range };
  const axes = makeAxes({ width, height, x: x_range, y: y_range, title, xLabel: x_label, yLabel: y_label, left, right });
  const node = svg("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": plainText(title) }, axes.node);
  node.append(svg("line", { class: "axis", x1: axes.left, x2: axes.right, y1: axes.y(0), y2: axes.y(0) }));
  const clip = `clip-${++drawPanel.count}`;
  node.append(svg("clipPath", { id: clip }, svg("rect", { x: axes.left, y: axes.top - 4, width: axes.right - axes.left, height: axes.floor - axes.top + 8 })));
  const group = svg("g", { "clip-path": `url(#${clip})` }, svg("path", { d: linePath(lines[0].x, lines[0].y, axes) + `L${axes.x(lines[0].x.at(-1))},${axes.y(0)}L${axes.x(lines[0].x[0])},${axes.y(0)}Z`, fill: ink("blue"), "fill-opacity": 0.1 }), ...lines.map(s => drawSeries(s, axes)));
  x.forEach((at, k) => {
    if (status[k] !== "o") group.append(markNode(statusMark[status[k]], axes.x(at), axes.y(marked[k]), x.length > 60 ? 2.4 : 3.6, ink(statusInk[status[k]])));
  });
  node.append(group);
  attachReadOut(node, panel, axes);
  return node;
}

// Shares along the path, with a line at the step shown. `lines`: [label, values, ink].
function pathPanel(title, y_label, steps, lines, now, y_range, width) {
  const mark = steps.length > 60 ? "line" : "line_dots", now_line = { label: "", x: [now, now], y: y_range || [], ink: "grey", mark: "thin", low: [], high: [] };
  const series = lines.map(([label, y, colour]) => ({ label, x: steps, y, ink: colour, mark, low: [], high: [] }));
  const panel = { title, x_label: "load step", y_label, zero_line: true, y_range, x_range: [steps[0] - 0.5, steps[steps.length - 1] + 0.5], series: [now_line, ...series] };
  return html("div", {}, legend(series), drawPanel(panel, width, 220, false));
}

// A contact on a slider. A subclass gives its controls and draws the step `index`.
class StepView {
  constructor(data, box) {
    this.data = data;
    this.box = box;
    this.index = data.shown;
    this.readout = html("div", { class: "readout" });
    this.stage = html("div", { class: "stage" });
    this.bar = html("div", {});
    this.below = html("div", {});
    this.slider = html("input", { type: "range", min: 0, max: data.steps.length - 1, step: 1, value: this.index, "aria-label": "load step" });
    this.slider.addEventListener("input", () => this.show(Number(this.slider.value)));
    this.playing = null;
    this.play = html("button", { type: "button", "aria-pressed": "false" }, "▶ Play");
    this.play.addEventListener("click", () => this.playing ? this.stop() : this.start());
  }
  // Buttons of which one is pressed; `chosen` takes its number.
  choice(names, label, chosen) {
    const buttons = names.map((name, k) => {
      const button = html("button", { type: "button", "aria-pressed": k === 0 }, ...richHtml(name));
      button.addEventListener("click", () => {
        buttons.forEach((b, i) => b.setAttribute("aria-pressed", i === k));
        chosen(k);
        this.draw();
      });
      return button;
    });
    return html("div", { class: "choice", role: "group", "aria-label": label }, ...buttons);
  }
  fill(...parts) {
    this.box.replaceChildren(this.readout, html("div", { class: "controls" }, this.play, this.slider), ...parts, this.below);
    if (this.data.steps.length < 2) this.play.parentNode.remove();
  }
  // Numbers of the step: [name, value, unit].
  read(step, entries) {
    this.slider.setAttribute("aria-valuetext", `load step ${step.number}`);
    const entry = ([name, value, unit]) => html("div", {}, ...richHtml(name), html("b", {}, value, html("small", {}, unit ? " " + unit : "")));
    this.readout.replaceChildren(...[["load step", `${step.number}`, `of ${this.data.path.number.length}`], ...entries].map(entry));
  }
  start() {
    this.play.textContent = "⏸ Pause";
    if (this.index === this.data.steps.length - 1) this.show(0);
    this.playing = setInterval(() => this.index + 1 < this.data.steps.length ? this.show(this.index + 1) : this.stop(), 450);
  }
  stop() {
    clearInterval(this.playing);
    this.playing = null;
    this.play.textContent = "▶ Play";
  }
  show(index) {
    this.index = index;
    this.slider.value = index;
    this.draw();
  }
}
