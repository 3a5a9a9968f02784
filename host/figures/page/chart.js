// SPDX-License-Identifier: Apache-2.0

// Figures of panels: series over axes, one legend a figure, a read-out under the pointer, all data as CSV.

// Dashes of lines, and marks on them. Shear is dashed, since its colour alone is too near to that of pressure for some eyes.
const dashes = { dashed: "5 4", long_dashes: "11 3", dash_triangles: "11 3" };

function markPath(mark, x, y, r) {
  switch (mark) {
    case "dash_triangles":
    case "triangles": return `M${x},${y - 1.25 * r}L${x + 1.15 * r},${y + 0.85 * r}L${x - 1.15 * r},${y + 0.85 * r}Z`;
    case "crosses": return `M${x - r},${y - r}L${x + r},${y + r}M${x - r},${y + r}L${x + r},${y - r}`;
    case "diamonds": return `M${x},${y - 1.5 * r}L${x + 1.5 * r},${y}L${x},${y + 1.5 * r}L${x - 1.5 * r},${y}Z`;
    default: return `M${x - r},${y}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0Z`;
  }
}
function markNode(mark, x, y, r, colour, more) {
  const open = mark === "crosses";
  return svg("path", {
    d: markPath(mark, x, y, r), fill: open ? "none" : colour, stroke: open ? colour : mark === "dots" ? null : "var(--card)",
    "stroke-width": open ? 1.8 : 1.1, "paint-order": "stroke", ...more,
  });
}

const finite = v => v !== null && v !== undefined && isFinite(v);

function linePath(xs, ys, axes) {
  let path = "", pen = false;
  for (let k = 0; k < xs.length; ++k) {
    const x = axes.x(xs[k]), y = finite(ys[k]) ? axes.y(ys[k]) : NaN;
    if (!isFinite(x) || !isFinite(y)) { pen = false; continue; }
    path += `${pen ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`;
    pen = true;
  }
  return path;
}

function bandPath(s, axes) {
  const high = [], low = [];
  s.x.forEach((x, k) => {
    if (!finite(s.low[k]) || !finite(s.high[k])) return;
    high.push(`${axes.x(x).toFixed(1)},${axes.y(s.high[k]).toFixed(1)}`);
    low.unshift(`${axes.x(x).toFixed(1)},${axes.y(s.low[k]).toFixed(1)}`);
  });
  return high.length ? `M${high.join("L")}L${low.join("L")}Z` : "";
}

function drawSeries(s, axes) {
  const colour = ink(s.ink), group = svg("g", {});
  const lined = { line: 1.9, thin: 1.1, dashed: 1.5, long_dashes: 1.9, line_dots: 1.6, dash_triangles: 1.6 }[s.mark];
  if (s.mark === "band") group.append(svg("path", { d: bandPath(s, axes), fill: colour, "fill-opacity": 0.16 }));
  if (lined) group.append(svg("path", { d: linePath(s.x, s.y, axes), fill: "none", stroke: colour, "stroke-width": lined, "stroke-linejoin": "round", "stroke-dasharray": dashes[s.mark] }));
  if (s.mark === "bars") {
    const gaps = s.x.slice(1).map((x, k) => Math.abs(axes.x(x) - axes.x(s.x[k])));
    const wide = Math.max(1.5, 0.86 * (gaps.length ? Math.min(...gaps) : 40)), base = axes.y.log ? axes.floor : axes.y(0);
    s.x.forEach((x, k) => {
      if (!finite(s.y[k]) || (axes.y.log && s.y[k] <= 0)) return;
      const y = axes.y(s.y[k]);
      group.append(svg("rect", { x: axes.x(x) - wide / 2, y: Math.min(y, base), width: wide, height: Math.abs(base - y), fill: colour, "fill-opacity": 0.75 }));
    });
  }
  if (s.mark === "whiskers")
    s.x.forEach((x, k) => {
      const at = axes.x(x);
      if (!finite(s.y[k])) return;
      if (finite(s.low[k]) && finite(s.high[k])) group.append(svg("line", { x1: at, x2: at, y1: axes.y(s.low[k]), y2: axes.y(s.high[k]), stroke: colour, "stroke-width": 2 }));
      group.append(markNode("circles", at, axes.y(s.y[k]), 4, colour));
    });
  if (["dots", "circles", "triangles", "crosses", "diamonds", "line_dots", "dash_triangles"].includes(s.mark)) {
    const many = s.x.length > 150, r = s.mark === "dots" ? (many ? 1.5 : 2.2) : s.mark === "line_dots" || s.mark === "dash_triangles" ? 2.8 : 4.2;
    const more = s.mark === "dots" ? { "fill-opacity": many ? 0.45 : 0.6 } : {};
    s.x.forEach((x, k) => {
      const px = axes.x(x), py = finite(s.y[k]) ? axes.y(s.y[k]) : NaN;
      if (isFinite(px) && isFinite(py)) group.append(markNode(s.mark, px, py, r, colour, more));
      if (s.names && s.names[k] && isFinite(px) && isFinite(py)) {
        const flip = px + 8 + textWidth(s.names[k]) > axes.right;
        group.append(svgText(flip ? px - 7 : px + 7, py - 6, s.names[k], { class: "halo", "text-anchor": flip ? "end" : "start", style: `fill:${colour}` }));
      }
    });
  }
  return group;
}

// Nearest drawn point of a panel, for the read-out.
function nearest(panel, axes, x, y) {
  let best = { distance: 34 };
  for (const s of panel.series)
    s.x.forEach((at, k) => {
      if (!finite(s.y[k]) || s.mark === "band") return;
      const distance = Math.hypot(axes.x(at) - x, axes.y(s.y[k]) - y);
      if (distance < best.distance) best = { distance, s, k };
    });
  return best.s ? best : null;
}
const unitOf = label => (/\(([^()]*)\)\s*$/.exec(label || "") || [, ""])[1];
const nameOf = label => (label || "").replace(/\s*\([^()]*\)\s*$/, "");

function readOut(panel, { s, k }) {
  const value = (label, v) => `${nameOf(label) || "value"} ${number(v)} ${unitOf(label)}`;
  const named = (panel.x_ticks || []).find(([at]) => Math.abs(at - s.x[k]) < 0.45);
  const lines = [named ? named[1] : value(panel.x_label || "x", s.x[k]), value(panel.y_label, s.y[k])];
  if (s.label) lines.unshift(s.label + (s.names && s.names[k] ? ": " + s.names[k] : ""));
  if (s.low.length && finite(s.low[k])) lines.push(`${number(s.low[k])} to ${number(s.high[k])}`);
  return lines;
}

function attachReadOut(node, panel, axes) {
  const spot = svg("circle", { r: 6, fill: "none", stroke: ink("ink"), "stroke-width": 1.5, visibility: "hidden", "pointer-events": "none" });
  node.append(svg("rect", { x: axes.left, y: axes.top, width: axes.right - axes.left, height: Math.max(0, axes.floor - axes.top), fill: "transparent" }), spot);
  const hide = () => { hideTip(); spot.setAttribute("visibility", "hidden"); };
  node.addEventListener("pointerleave", hide);
  node.addEventListener("pointermove", event => {
    const box = node.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const found = nearest(panel, axes, x, y);
    if (found) {
      spot.setAttribute("cx", axes.x(found.s.x[found.k]));
      spot.setAttribute("cy", axes.y(found.s.y[found.k]));
      spot.setAttribute("visibility", "visible");
      return showTip(event, readOut(panel, found));
    }
    spot.setAttribute("visibility", "hidden");
    const r = panel.raster, u = axes.x.range[0] + (x - axes.left) / (axes.right - axes.left) * (axes.x.range[1] - axes.x.range[0]);
    const v = axes.y.range[0] + (axes.floor - y) / (axes.floor - axes.top) * (axes.y.range[1] - axes.y.range[0]);
    if (!r) return hideTip();
    const column = Math.floor((u - r.x_range[0]) / (r.x_range[1] - r.x_range[0]) * r.columns), row = Math.floor((v - r.y_range[0]) / (r.y_range[1] - r.y_range[0]) * r.rows);
    if (column < 0 || row < 0 || column >= r.columns || row >= r.rows) return hideTip();
    showTip(event, [`x ${number(u, 3)}, y ${number(v, 3)}`, `${number(r.values[row * r.columns + column], 3)} ${r.unit}`]);
  });
}

// Names at the ends of lines, moved apart; in place of a legend where they fit.
function endLabels(panel, axes) {
  const labels = panel.series.filter(s => s.label).map(s => {
    let k = s.x.length - 1;
    while (k >= 0 && !finite(s.y[k])) --k;
    return k < 0 ? null : { s, y: axes.y(s.y[k]) };
  }).filter(Boolean).sort((a, b) => a.y - b.y);
  for (let i = 1; i < labels.length; ++i) labels[i].y = Math.max(labels[i].y, labels[i - 1].y + 14);
  return labels.map(l => svgText(axes.right + 7, l.y + 4, l.s.label, { style: `fill:${ink(l.s.ink)};font-weight:600` }));
}

function directly(figure, width) {
  if (figure.panels.length !== 1 || width < 520) return false;
  const labelled = figure.panels[0].series.filter(s => s.label);
  return labelled.length > 1 && labelled.length <= 6 && labelled.every(s => ["line", "thin", "dashed", "line_dots"].includes(s.mark) && s.x.length > 1);
}

function drawPanel(panel, width, height, direct) {
  const r = panel.raster, all = panel.series;
  const x = rangeOf([...all.flatMap(s => s.x), ...(r ? r.x_range : [])], panel.x_range || (r && r.x_range), panel.log_x, panel.x_ticks ? 0.08 : 0.02);
  const bars = all.some(s => s.mark === "bars") || panel.zero_line;
  let y = rangeOf([...all.flatMap(s => [...s.y, ...s.low, ...s.high]), ...(bars && !panel.log_y ? [0] : [])], panel.y_range || (r && r.y_range), panel.log_y, 0.05);
  if (bars && !panel.log_y && !panel.y_range && Math.abs(y[0]) < 0.06 * (y[1] - y[0])) y = [0, y[1]];
  const right = direct ? 14 + Math.max(...all.map(s => textWidth(s.label))) : 10;
  const axes = makeAxes({ width, height, x, y, title: panel.title, xLabel: panel.x_label, yLabel: panel.y_label, xTicks: panel.x_ticks, logX: panel.log_x, logY: panel.log_y, right });
  const node = svg("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": plainText([panel.title, panel.y_label, panel.x_label && "over " + panel.x_label].filter(Boolean).join(", ")) }, axes.node);
  const out = html("div", {}, node);
  if (r) {
    const drawn = drawRaster(r, axes);
    node.append(drawn.node);
    if (r.palette !== "status") out.append(scaleBar(r.palette, drawn.limits, r.unit));
  }
  if (panel.zero_line && y[0] < 0) node.append(svg("line", { class: "axis", x1: axes.left, x2: axes.right, y1: axes.y(0), y2: axes.y(0) }));
  const clip = `clip-${++drawPanel.count}`;
  node.append(svg("clipPath", { id: clip }, svg("rect", { x: axes.left - 6, y: axes.top - 6, width: axes.right - axes.left + 12, height: Math.max(0, axes.floor - axes.top + 12) })));
  node.append(svg("g", { "clip-path": `url(#${clip})` }, ...all.map(s => drawSeries(s, axes))));
  if (direct) node.append(...endLabels(panel, axes));
  attachReadOut(node, panel, axes);
  return out;
}
drawPanel.count = 0;

function legendSample(s) {
  const colour = ink(s.ink), node = svg("svg", { width: 22, height: 12 });
  if (s.mark === "band") node.append(svg("rect", { y: 1, width: 22, height: 10, fill: colour, "fill-opacity": 0.2 }));
  else if (s.mark === "bars") node.append(svg("rect", { x: 5, y: 1, width: 12, height: 10, fill: colour, "fill-opacity": 0.75 }));
  else {
    if (["line", "thin", "dashed", "long_dashes", "line_dots", "dash_triangles"].includes(s.mark)) node.append(svg("line", { x1: 0, x2: 22, y1: 6, y2: 6, stroke: colour, "stroke-width": s.mark === "line" ? 2.4 : 1.6, "stroke-dasharray": dashes[s.mark] }));
    if (s.mark === "whiskers") node.append(svg("line", { x1: 11, x2: 11, y1: 0, y2: 12, stroke: colour, "stroke-width": 2 }));
    if (!["line", "thin", "dashed", "long_dashes"].includes(s.mark)) node.append(markNode(s.mark, 11, 6, s.mark === "dots" ? 3 : 3.8, colour));
  }
  return node;
}
function legend(series) {
  const seen = new Map();
  for (const s of series) if (s.label && !seen.has(s.label + s.ink)) seen.set(s.label + s.ink, s);
  return html("div", { class: "legend" }, ...[...seen.values()].map(s => html("span", {}, legendSample(s), html("span", {}, ...richHtml(s.label)))));
}

// Every point of a figure, a row each; of a raster the middles of its cells.
function figureRows(figure) {
  const series = figure.panels.flatMap(p => p.series), ranged = series.some(s => s.low.length), mapped = figure.panels.some(p => p.raster);
  const rows = [["panel", "series", "x axis", "x", "y axis", "y", ...(ranged ? ["low", "high"] : []), ...(mapped ? ["value"] : [])]];
  figure.panels.forEach((panel, p) => {
    const name = plainText(panel.title || panel.y_label || `panel ${p + 1}`), x_axis = plainText(panel.x_label || "x"), y_axis = plainText(panel.y_label || "y");
    for (const s of panel.series)
      s.x.forEach((x, k) => rows.push([name, plainText(s.label), x_axis, x, y_axis, s.y[k], ...(ranged ? [s.low[k], s.high[k]] : []), ...(mapped ? [null] : [])]));
    const r = panel.raster, middle = (range, i, n) => parseFloat((range[0] + (i + 0.5) / n * (range[1] - range[0])).toPrecision(7));
    if (r) r.values.forEach((value, k) => rows.push([name, plainText(r.unit), x_axis, middle(r.x_range, k % r.columns, r.columns),
      y_axis, middle(r.y_range, Math.floor(k / r.columns), r.rows), ...(ranged ? [null, null] : []), value]));
  });
  return rows;
}

function chart(figure, box) {
  const width = Math.max(240, box.clientWidth), columns = width < 560 ? 1 : figure.columns;
  const each = Math.floor((width - 26 * (columns - 1)) / columns), direct = directly(figure, width);
  const height = Math.round(Math.min(figure.height, 0.62 * each + 90));
  const series = figure.panels.flatMap(p => p.series);
  const labels = new Set(series.map(s => s.label).filter(Boolean));
  const parts = labels.size && !direct ? [legend(series)] : [];
  if (figure.panels.some(p => p.raster && p.raster.palette === "status")) parts.push(statusLegend());
  parts.push(html("div", { class: "panels", style: `grid-template-columns:repeat(${columns},minmax(0,1fr))` }, ...figure.panels.map(p => drawPanel(p, each, height, direct))));
  box.replaceChildren(...parts);
}
