// SPDX-License-Identifier: Apache-2.0

// A pad's contact over its load steps, from above: tractions and status of the cells; the pad with its tactels, the
// indenter and the forces; cuts along the indenter's own axes; forces and slip index along the path.

// Axes of a map on which a millimetre has one length along both: the range that is too short grows.
const mapFrame = { left: 40, right: 10, rest: 79 };  // pixels beside the axes and over and below them
function mapHeight(width, [x, y]) {
  return Math.min(560, mapFrame.rest + (width - mapFrame.left - mapFrame.right) * (y[1] - y[0]) / (x[1] - x[0]));
}
function mapAxes(width, height, [x, y], title) {
  const { left, right, rest } = mapFrame, inner = width - left - right, room = height - rest;
  const scale = Math.min(inner / (x[1] - x[0]), room / (y[1] - y[0]));
  const wide = ([low, high], pixels) => { const more = (pixels / scale - (high - low)) / 2; return [low - more, high + more]; };
  return { ...makeAxes({ width, height, x: wide(x, inner), y: wide(y, room), title, xLabel: "x (mm)", yLabel: "y (mm)", left, right }), scale, width, height };
}
const square = ([x, y], extra) => {
  const more = extra * Math.max(x[1] - x[0], y[1] - y[0]);
  return [[x[0] - more, x[1] + more], [y[0] - more, y[1] + more]];
};
// The smallest window around points.
function around(points) {
  const range = k => [Math.min(...points.map(p => p[k])), Math.max(...points.map(p => p[k]))];
  return [range(0), range(1)];
}
// A length that arrows of a scale are explained with: 1, 2 or 5 times a power of ten.
function roundBelow(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map(f => f * power).find(v => v <= most * (1 + 1e-9));
}

class PadView extends StepView {
  constructor(data, box) {
    super(data, box);
    const { cells: { n, sides, middle }, yaw } = data, angle = yaw * Math.PI / 180;
    this.turn = [Math.cos(angle), Math.sin(angle)];
    this.own = k => middle.map((m, axis) => m + ((axis ? k % n : Math.floor(k / n)) - (n - 1) / 2) * sides[axis]);
    this.cut = [0, 1].map(axis => Math.min(n - 1, Math.max(0, Math.floor(n / 2 - middle[axis] / sides[axis] + 1e-6))));  // the cell below the axis
    this.quantity = 0;
    this.mu = k => data.mu[k] ?? data.mu;  // of a cell; one number without a map
    this.mostMu = Math.max(...[data.mu].flat());
    const size = (s, k) => Math.hypot(s.tx[k], s.ty[k]);
    this.quantities = [
      { name: "pressure p", of: (s, k) => s.p[k], most: data.most.p, unit: "MPa" },
      { name: "shear |t|", of: size, most: data.most.t, unit: "MPa" },
      { name: "used grip |t| / µp", of: (s, k) => this.mu(k) * s.p[k] > 0 ? Math.min(1, size(s, k) / (this.mu(k) * s.p[k])) : 0, most: 1, unit: "" },
    ];
    this.readout.classList.add("pairs");
    const choice = this.choice(this.quantities.map(q => q.name), "quantity that colours the cells", k => { this.quantity = k; });
    this.fill(html("div", { class: "controls" }, choice, this.bar), this.stage);
  }
  // A place of the indenter's own frame on the pad, and back.
  place([x, y]) {
    const [c, s] = this.turn, [x0, y0] = this.data.position;
    return [x0 + c * x - s * y, y0 + s * x + c * y];
  }
  ownPlace([x, y]) {
    const [c, s] = this.turn, [u, v] = [x - this.data.position[0], y - this.data.position[1]];
    return [c * u + s * v, c * v - s * u];
  }
  corners(k) {
    const { sides } = this.data.cells, [x, y] = this.own(k);
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => this.place([x + a * sides[0] / 2, y + b * sides[1] / 2]));
  }
  // Corners of the cells at the corners of the grid.
  rim() {
    const { n } = this.data.cells;
    return [0, n - 1, n * n - 1, n * n - n].flatMap(k => this.corners(k));
  }
  // Index of the cell at a place of the pad; -1 where none is.
  cellAt(place) {
    const { n, sides, middle } = this.data.cells, [i, j] = this.ownPlace(place).map((v, axis) => Math.floor((v - middle[axis]) / sides[axis] + n / 2));
    return i >= 0 && j >= 0 && i < n && j < n ? i * n + j : -1;
  }

  draw() {
    const { data } = this, step = data.steps[this.index], width = Math.max(240, this.box.clientWidth);
    const pair = (values, digits) => values.map(v => fixed(v, digits)).join(", ");
    this.read(step, [["depth", fixed(step.indentation, 3), "mm"], ["drag x, y", pair(step.drag, 3), "mm"], ["twist", fixed(step.twist, 2), "°"], ["part that sticks", fixed(data.path.stick[step.number - 1], 2), ""],
      ["P, normal force", fixed(step.P, 3), "N"], ["Q_x, Q_y, tangential", pair(step.Q, 3), "N"], ["M, torque", fixed(step.M, 3), "N mm"], ["S, slip index", fixed(step.S, 3), ""], ["|Q| / µP", fixed(step.ratio, 3), ""]]);
    const columns = width < 640 ? 1 : 2, each = Math.floor((width - 26 * (columns - 1)) / columns);
    const grid = (count, ...parts) => html("div", { class: "panels", style: `grid-template-columns:repeat(${count},minmax(0,1fr));margin-top:.8rem;align-items:end` }, ...parts);
    const { tactels, pitch } = data.sensor, nearby = place => place.map((v, k) => Math.sign(v) * Math.min(Math.abs(v), 0.65 * tactels[k] * pitch[k]));  // a wide pad is cut off
    const windows = [square(around(this.rim()), 0.05), square(around([...this.sides().map(nearby), ...this.rim()]), 0.04)],
      heights = windows.map(w => mapHeight(each, w));
    const height = k => columns === 1 ? heights[k] : Math.max(...heights);
    const maps = [this.surface(mapAxes(each, height(0), windows[0], "On the surface"), step), this.pad(mapAxes(each, height(1), windows[1], "What the tactels feel"), step)];
    if (data.markers) {
      const window = square(around([...data.markers, ...this.rim()]), 0.04);
      maps.push(this.markers(mapAxes(each, mapHeight(each, window), window, "How the markers move"), step));
    }
    this.stage.replaceChildren(grid(columns, ...maps));
    const q = this.quantities[this.quantity];
    this.bar.replaceChildren(scaleBar("sequential", [0, q.most || 1], [q.unit, q.name].filter(Boolean).join(", ")));
    const parts = [this.cutAlong(0, each, step), this.cutAlong(1, each, step)];
    this.below.replaceChildren(this.cutLegend(), grid(columns, ...parts), ...(data.path.number.length > 1 ? [grid(columns === 1 ? 1 : 3, ...this.paths(columns === 1 ? width : Math.floor((width - 52) / 3), step))] : []));
  }
  map(axes, label, everywhere) {
    const node = svg("svg", { width: axes.width, height: axes.height, viewBox: `0 0 ${axes.width} ${axes.height}`, role: "img", "aria-label": label });
    const clip = `clip-${++drawPanel.count}`, box = { x: axes.left, y: axes.top, width: axes.right - axes.left, height: axes.floor - axes.top };
    const inner = svg("g", { "clip-path": `url(#${clip})` });
    node.append(svg("clipPath", { id: clip }, svg("rect", box)), ...(everywhere ? [svg("rect", { ...box, fill: ink("rubber"), "fill-opacity": 0.6 })] : []), axes.node, inner);
    const at = event => {
      const r = node.getBoundingClientRect(), [px, py] = [event.clientX - r.left, event.clientY - r.top];
      const value = (scale, v) => scale.range[0] + (v - scale.pixels[0]) / (scale.pixels[1] - scale.pixels[0]) * (scale.range[1] - scale.range[0]);
      return [value(axes.x, px), value(axes.y, py)];
    };
    const path = (points, closed) => `M${points.map(([x, y]) => `${axes.x(x).toFixed(1)},${axes.y(y).toFixed(1)}`).join("L")}${closed ? "Z" : ""}`;
    node.addEventListener("pointerleave", hideTip);
    return { node, inner, at, path };
  }
  // Lines along its own axes through an own place, and the part of the indenter below the undeformed surface.
  indenter(path, reach, through) {
    const out = [], outline = this.data.outlines[this.data.steps[this.index].outline];
    for (const axis of [0, 1]) {
      const end = sign => this.place(through.map((v, k) => k === axis ? v + sign * reach : v));
      out.push(svg("path", { d: path([end(-1), end(1)]), fill: "none", stroke: ink("ink"), "stroke-opacity": 0.45, "stroke-width": 0.9, "stroke-dasharray": "9 3 2 3" }));
    }
    if (outline.length) out.push(svg("path", { d: path(outline, true), fill: "none", stroke: ink("card"), "stroke-width": 4, "stroke-opacity": 0.7 }), svg("path", { d: path(outline, true), fill: "none", stroke: ink("ink"), "stroke-width": 1.7, "stroke-dasharray": "6 4" }));
    return out;
  }
  // Edges between cells of which one alone is `within`.
  border(step, path, within) {
    const { n } = this.data.cells, is = (i, j) => i >= 0 && j >= 0 && i < n && j < n && within(step.status[i * n + j]);
    let d = "";
    for (let k = 0; k < n * n; ++k) {
      const i = Math.floor(k / n), j = k % n;
      if (!is(i, j)) continue;
      const c = this.corners(k);
      [[0, -1], [1, 0], [0, 1], [-1, 0]].forEach(([a, b], side) => { if (!is(i + a, j + b)) d += path([c[side], c[(side + 1) % 4]]); });
    }
    return d;
  }

  surface(axes, step) {
    const { data } = this, { n } = data.cells, { node, inner, at, path } = this.map(axes, `Contact from above at load step ${step.number}`, true);
    const q = this.quantities[this.quantity], colour = colouring("sequential", [0, q.most || 1]), marks = [];
    let open = "", shafts = "", heads = "";
    const every = Math.ceil(n / 16), long = 1.35 * every * axes.scale * Math.sqrt(data.cells.sides[0] * data.cells.sides[1]) / (data.most.t || 1);
    for (let k = 0; k < n * n; ++k) {
      const shape = path(this.corners(k), true);
      if (step.status[k] === "o") { open += shape; continue; }
      const fill = css(colour(q.of(step, k)));
      inner.append(svg("path", { d: shape, fill, stroke: fill, "stroke-width": 0.6 }));
      if (Math.floor(k / n) % every || k % n % every) continue;
      const [x, y] = this.place(this.own(k)), [px, py] = [axes.x(x), axes.y(y)], arrow = arrowPaths(px, py, px + long * step.tx[k], py - long * step.ty[k], 6);
      if (arrow) { shafts += arrow.shaft; heads += arrow.head; }
      marks.push(markNode(statusMark[step.status[k]], px, py, Math.min(3.6, 0.13 * axes.scale * Math.min(...data.cells.sides) * every), ink(statusInk[step.status[k]])));
    }
    const line = (d, more) => svg("path", { d, fill: "none", "stroke-linecap": "round", ...more });
    inner.prepend(line(open, { stroke: ink("line"), "stroke-width": 0.7 }));
    const sticks = this.border(step, path, s => s === "t"), reach = 2 * (axes.right - axes.left) / axes.scale, through = this.own(this.cut[0] * n + this.cut[1]);
    inner.append(line(sticks, { stroke: ink("card"), "stroke-width": 4.6 }), line(sticks, { stroke: ink("green"), "stroke-width": 2.4 }), ...this.indenter(path, reach, through),
      line(shafts, { stroke: ink("card"), "stroke-width": 3.4, "stroke-opacity": 0.8 }), svg("path", { d: heads, fill: ink("ink"), stroke: ink("card"), "stroke-width": 1.2, "paint-order": "stroke" }),
      line(shafts, { stroke: ink("ink"), "stroke-width": 1.4 }), ...marks);
    node.append(...this.axisNames(axes, through));
    node.style.cursor = "crosshair";
    node.addEventListener("pointermove", event => this.tellCell(event, this.cellAt(at(event)), step));
    node.addEventListener("click", event => {
      const k = this.cellAt(at(event));
      if (k < 0) return;
      this.cut = [Math.floor(k / n), k % n];
      this.draw();
    });
    return html("div", {}, this.keys(statusLegend("tl"), this.arrowKey(data.most.t, long, "t")), node);
  }
  // x' and y' at the rim of the map.
  axisNames(axes, through) {
    const out = [], [[left, right], [bottom, top]] = [axes.x.range, axes.y.range], inset = 11 / axes.scale;
    for (const axis of [0, 1]) {
      const from = this.place(through), way = axis ? [-this.turn[1], this.turn[0]] : this.turn;
      const far = way.map((w, k) => Math.abs(w) < 1e-9 ? Infinity : ((w > 0 ? [right, top][k] - inset : [left, bottom][k] + inset) - from[k]) / w), reach = Math.min(...far);
      if (!(reach > 0)) continue;
      const [x, y] = from.map((v, k) => v + reach * way[k]);
      out.push(svgText(axes.x(x) - 8 * Math.abs(way[1]), axes.y(y) - 7 * Math.abs(way[0]) + 4, axis ? "y′" : "x′", { class: "halo", "text-anchor": "middle", style: `fill:${ink("ink")};font-style:italic;font-weight:650` }));
    }
    return out;
  }
  tellCell(event, k, step) {
    if (k < 0) return hideTip();
    const [x, y] = this.place(this.own(k)), status = step.status[k], used = this.quantities[2].of(step, k), shear = Math.hypot(step.tx[k], step.ty[k]);
    showTip(event, [`x ${number(x, 3)} mm, y ${number(y, 3)} mm: ${statusWord[status]}`,
      ...(status === "o" ? [] : [`p ${number(step.p[k])} MPa`, `t_x ${number(step.tx[k], 3)}, t_y ${number(step.ty[k], 3)} MPa`, `|t| ${number(shear, 3)} MPa, |t| / µp ${fixed(used, 3)}`])]);
  }
  keys(...parts) { return html("div", { class: "legend" }, ...parts.flatMap(p => p.classList.contains("legend") ? [...p.childNodes] : [p])); }
  arrowKey(most, long, name, unit = "MPa") {
    if (!(most > 0)) return html("span", {});
    const value = roundBelow(most), arrow = arrowPaths(1, 6, 1 + long * value, 6, 6, 0), wide = Math.ceil(long * value) + 4;
    return html("span", {}, svg("svg", { width: wide, height: 12 }, svg("path", { d: arrow.shaft, stroke: ink("ink"), "stroke-width": 1.4 }), svg("path", { d: arrow.head, fill: ink("ink") })), `${name}: ${number(value)} ${unit}`);
  }

  // Corners of the pad, or of the part of it that the tactels take.
  sides() {
    const { tactels, pitch, length, width } = this.data.sensor, [x, y] = [length ?? tactels[0] * pitch[0], width ?? tactels[1] * pitch[1]].map(v => v / 2);
    return [[-x, -y], [x, -y], [x, y], [-x, y]];
  }
  // The pad: its rubber, its tactels, the contact, the indenter, and the forces.
  pad(axes, step) {
    const { data } = this, { tactels: [nx, ny], pitch, size, axes: measured, length, width } = data.sensor, known = length !== null && width !== null;
    const { node, inner, at, path } = this.map(axes, `The pad at load step ${step.number}`, !known);
    if (known) inner.append(svg("path", { d: path(this.sides(), true), fill: ink("rubber"), stroke: ink("steel-edge"), "stroke-width": 2.4 }));
    const tile = pitch.map(p => Math.max(size, 0.74 * p) * axes.scale), colour = colouring("diverging", [-data.most.sigma || -1, data.most.sigma || 1]);
    const long = 0.62 * Math.min(...pitch) * axes.scale / (data.most.tau || 1), middle = (i, j) => [(i - (nx - 1) / 2) * pitch[0], (j - (ny - 1) / 2) * pitch[1]];
    let shafts = "", heads = "";
    for (let j = 0; j < ny; ++j)
      for (let i = 0; i < nx; ++i) {
        const k = j * nx + i, [x, y] = middle(i, j), [px, py] = [axes.x(x), axes.y(y)];
        inner.append(svg("rect", { x: px - tile[0] / 2, y: py - tile[1] / 2, width: tile[0], height: tile[1], rx: Math.min(4, 0.12 * tile[0]), fill: css(colour(step.sigma[k])), stroke: ink("faint"), "stroke-width": 0.7 }));
        const arrow = measured === 3 && arrowPaths(px, py, px + long * step.tau_x[k], py - long * step.tau_y[k], 7);
        if (arrow) { shafts += arrow.shaft; heads += arrow.head; }
      }
    const line = (d, more) => svg("path", { d, fill: "none", ...more }), touched = this.border(step, path, s => s !== "o"), reach = 2 * (axes.right - axes.left) / axes.scale;
    inner.append(...this.indenter(path, reach, [0, 0]), line(touched, { stroke: ink("ink"), "stroke-width": 1.3 }),
      line(shafts, { stroke: ink("card"), "stroke-width": 3.6, "stroke-opacity": 0.8 }), svg("path", { d: heads, fill: ink("ink"), stroke: ink("card"), "stroke-width": 1.2, "paint-order": "stroke" }), line(shafts, { stroke: ink("ink"), "stroke-width": 1.6 }));
    node.append(...this.axisNames(axes, [0, 0]), ...this.forces(axes, step));
    node.addEventListener("pointermove", event => {
      const [x, y] = at(event), i = Math.round(x / pitch[0] + (nx - 1) / 2), j = Math.round(y / pitch[1] + (ny - 1) / 2);
      if (i < 0 || j < 0 || i >= nx || j >= ny) return hideTip();
      const k = j * nx + i, [tx, ty] = middle(i, j);
      showTip(event, [`tactel ${i + 1}, ${j + 1} at ${number(tx, 3)}, ${number(ty, 3)} mm`, `σ_z ${number(step.sigma[k])} MPa`, ...(measured === 3 ? [`τ_x ${number(step.tau_x[k], 3)}, τ_y ${number(step.tau_y[k], 3)} MPa`] : [])]);
    });
    const bar = scaleBar("diverging", [-data.most.sigma || -1, data.most.sigma || 1], "MPa, σ_z");
    return html("div", {}, this.keys(bar, ...(measured === 3 ? [this.arrowKey(data.most.tau, long, "τ")] : [])), node);
  }
  // Markers where they rest, with arrows along the pad and colours of u_z.
  markers(axes, step) {
    const { markers, most } = this.data, { node, inner, path } = this.map(axes, `Markers at load step ${step.number}`, true), [x, y, z] = step.u;
    const colour = colouring("diverging", [-most.w || -1, most.w || 1]), [wide, tall] = around(markers).map(([low, high]) => high - low);
    const apart = Math.sqrt(Math.max(wide * tall, 1e-3 * Math.max(wide, tall) ** 2) / markers.length) || 1, long = 0.9 * apart * axes.scale / (most.u || 1);
    let shafts = "", heads = "";
    inner.append(...this.indenter(path, 2 * (axes.right - axes.left) / axes.scale, [0, 0]));
    markers.forEach((place, k) => {
      const [px, py] = [axes.x(place[0]), axes.y(place[1])], arrow = arrowPaths(px, py, px + long * x[k], py - long * y[k], 6);
      inner.append(svg("circle", { cx: px, cy: py, r: 4.5, fill: css(colour(z[k])), stroke: ink("faint"), "stroke-width": 0.8 }));
      if (arrow) { shafts += arrow.shaft; heads += arrow.head; }
    });
    inner.append(svg("path", { d: shafts, fill: "none", stroke: ink("ink"), "stroke-width": 1.4 }), svg("path", { d: heads, fill: ink("ink") }));
    return html("div", {}, this.keys(scaleBar("diverging", [-most.w || -1, most.w || 1], "mm, u_z"), this.arrowKey(most.u, long, "u", "mm")), node);
  }
  // Size that torques are drawn in: the largest, at least a twentieth of what the grip can bear.
  mostTorque() {
    const { path, cells: { n, sides } } = this.data, most = values => Math.max(...values.map(v => Math.abs(v ?? 0)));
    return Math.max(most(path.M), 0.05 * this.mostMu * most(path.P) * n * Math.max(...sides) / 2) || 1;
  }
  // Q as an arrow at the indenter's axis, M as an arc about it.
  forces(axes, step) {
    const { path, position } = this.data, [x, y] = [axes.x(position[0]), axes.y(position[1])], out = [], most = values => Math.max(...values.map(v => Math.abs(v ?? 0)));
    const all = Math.hypot(most(path.Qx), most(path.Qy)) || 1, long = 0.2 * (axes.right - axes.left) / all, text = { class: "halo", style: "font-weight:650" };
    const tip = [x + long * step.Q[0], y - long * step.Q[1]], q = forceArrow(x, y, ...tip, "purple");
    if (q.length) out.push(...q, svgText(tip[0] + (step.Q[0] < 0 ? -6 : 6), tip[1] + (step.Q[1] < 0 ? 14 : -5), `Q ${fixed(Math.hypot(...step.Q), 3)} N`, { ...text, "text-anchor": step.Q[0] < 0 ? "end" : "start", style: `fill:${ink("purple")};font-weight:650` }));
    const far = Math.max(...this.rim().map(p => Math.hypot(p[0] - position[0], p[1] - position[1]))), turned = 4.4 * step.M / this.mostTorque();
    const r = Math.min(0.36 * Math.min(axes.right - axes.left, axes.floor - axes.top), Math.max(22, 0.85 * far * axes.scale));
    if (Math.abs(turned) > 0.2) {
      const from = Math.PI / 2 - turned / 2, point = angle => [x + r * Math.cos(angle), y - r * Math.sin(angle)], [a, b] = [point(from), point(from + turned)];
      const way = Math.sign(turned), end = [b[0] - 9 * way * Math.sin(from + turned), b[1] - 9 * way * Math.cos(from + turned)];
      out.push(svg("path", { d: `M${a.map(v => v.toFixed(1))}A${r},${r} 0 ${Math.abs(turned) > Math.PI ? 1 : 0} ${way > 0 ? 0 : 1} ${b.map(v => v.toFixed(1))}`, fill: "none", stroke: ink("orange"), "stroke-width": 3 }),
        svg("path", { d: arrowPaths(b[0], b[1], ...end, 9).head, fill: ink("orange") }),
        svgText(x, y + r + 16, `M ${fixed(step.M, 3)} N mm`, { ...text, "text-anchor": "middle", style: `fill:${ink("orange")};font-weight:650` }));
    }
    return out;
  }

  // p, µp and |t| on the row of cells along one of the indenter's own axes.
  cutAlong(axis, width, step) {
    const { cells: { n, sides }, most } = this.data, row = Array.from({ length: n }, (_, i) => axis ? this.cut[0] * n + i : i * n + this.cut[1]);
    const at = row.map(k => this.own(k)[axis]), widths = row.map(() => sides[axis]), p = row.map(k => step.p[k]), t = row.map(k => Math.hypot(step.tx[k], step.ty[k]));
    const top = 1.06 * Math.max(most.p, most.t, Math.min(this.mostMu, 1.5) * most.p) || 1, name = ["x′", "y′"], aside = this.own(row[0])[1 - axis];
    return html("div", {}, tractionPanel({ title: `Along ${name[axis]}, at ${name[1 - axis]} = ${number(aside, 2)} mm`, x_label: `${name[axis]} (mm)`, y_label: "traction (MPa)", x_range: [at[0] - 1.2 * sides[axis], at[n - 1] + 1.2 * sides[axis]], y_range: [0, top], width },
      this.cutLines(at, widths, p, row.map((k, i) => this.mu(k) * p[i]), t), at, t, row.map(k => step.status[k])));
  }
  cutLines(at, widths, p, limit, t) {
    return [along("pressure p", at, widths, p, "blue", "line"), along("limit µp", at, widths, limit, "grey", "dashed"), along("shear |t|", at, widths, t, "orange", "long_dashes")];
  }
  cutLegend() {
    const key = legend(this.cutLines([], [], [], [], []));
    key.style.marginTop = "1.2rem";
    key.append(...statusLegend("tl").childNodes);
    key.append(html("span", {}, "A click on a cell cuts there."));
    return key;
  }
  paths(width, step) {
    const { number: steps, S, ratio, stick, P, Qx, Qy, M } = this.data.path;
    const range = (...lists) => { const all = lists.flat().filter(finite), low = Math.min(0, ...all), high = Math.max(0, ...all), room = 0.06 * (high - low) || 1; return [low < 0 ? low - room : 0, high + room]; };
    return [pathPanel("Grip", "share", steps, [["S", S, "black"], ["|Q| / µP", ratio, "orange"], ["part that sticks", stick, "green"]], step.number, [0, 1.06], width),
      pathPanel("Forces", "force (N)", steps, [["P", P, "blue"], ["Q_x", Qx, "purple"], ["Q_y", Qy, "brown"]], step.number, range(P, Qx, Qy), width),
      pathPanel("Torque", "torque about the indenter's axis (N mm)", steps, [["M", M, "orange"]], step.number, range(M, [Math.min(...M) < -0.1 * this.mostTorque() ? 0 : this.mostTorque()]), width)];
  }

  tables() { return [["CSV: surface", "surface", () => this.surfaceRows()], ["tactels", "tactels", () => this.tactelRows()], ["path", "path", () => this.pathRows()]]; }
  surfaceRows() {
    const rows = [["load step", "x (mm)", "y (mm)", "status", "pressure (MPa)", "t_x (MPa)", "t_y (MPa)"]];
    for (const s of this.data.steps)
      s.p.forEach((p, k) => rows.push([s.number, ...this.place(this.own(k)).map(v => parseFloat(v.toPrecision(6))), statusWord[s.status[k]], p, s.tx[k], s.ty[k]]));
    return rows;
  }
  tactelRows() {
    const { tactels: [nx, ny], pitch, axes } = this.data.sensor, rows = [["load step", "x (mm)", "y (mm)", "sigma_z (MPa)", ...(axes === 3 ? ["tau_x (MPa)", "tau_y (MPa)"] : [])]];
    for (const s of this.data.steps)
      s.sigma.forEach((sigma, k) => rows.push([s.number, (k % nx - (nx - 1) / 2) * pitch[0], (Math.floor(k / nx) - (ny - 1) / 2) * pitch[1], sigma, ...(axes === 3 ? [s.tau_x[k], s.tau_y[k]] : [])]));
    return rows;
  }
  pathRows() {
    const { number: steps, P, Qx, Qy, M, S, ratio, stick } = this.data.path;
    return [["load step", "P (N)", "Q_x (N)", "Q_y (N)", "M (N mm)", "S", "|Q| / (mu P)", "part that sticks"], ...steps.map((k, i) => [k, P[i], Qx[i], Qy[i], M[i], S[i], ratio[i], stick[i]])];
  }
}
