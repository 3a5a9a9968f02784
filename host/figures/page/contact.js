// SPDX-License-Identifier: Apache-2.0

// A contact over its load steps: cross-section with indenter, deformed rubber, status, forces, stress field and tactels;
// tractions below it, then tactels and path. A slider, or a play button, moves through the steps.

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out;
}
// Values of a quantity of a step: 8 bits between the quantity's limits over all steps.
function fieldValues(field, step, quantity) {
  const { low, high } = field.quantities[quantity];
  return Array.from(bytes(step.fields[quantity]), b => low + (high - low) * b / 255);
}

class ContactView extends StepView {
  constructor(data, box) {
    super(data, box);
    this.quantity = 2;  // after both displacements: sigma_y
    const choice = this.choice(data.field.quantities.slice(2).map(q => q.name), "stress that colours the rubber", k => { this.quantity = k + 2; });
    this.fill(this.stage, html("div", { class: "controls" }, choice, this.bar));
    this.values = new Map();
  }
  field(quantity) {
    const key = `${this.index}/${quantity}`;
    if (!this.values.has(key)) this.values.set(key, fieldValues(this.data.field, this.data.steps[this.index], quantity));
    return this.values.get(key);
  }

  draw() {
    const { data } = this, step = data.steps[this.index];
    this.read(step, [["depth", fixed(step.indentation, 3), "mm"], ["drag", fixed(step.tangential, 3), "mm"], ["P, normal force", fixed(step.P, 3), "N/mm"],
      ["Q, tangential", fixed(step.Q, 3), "N/mm"], [data.mu === null ? "S" : "S = Q / µP", fixed(step.S, 3), ""]]);
    const width = Math.max(240, this.box.clientWidth);
    this.stage.replaceChildren(...this.crossSection(width, step));
    const q = data.field.quantities[this.quantity];
    this.bar.replaceChildren(scaleBar(this.palette(), this.limits(), `MPa, ${q.name}`, q.clipped));
    this.below.replaceChildren(this.tractions(width, step), this.others(width));
  }
  palette() { return this.data.field.quantities[this.quantity].name === "von Mises" ? "sequential" : "diverging"; }
  limits() {
    const q = this.data.field.quantities[this.quantity];
    if (this.palette() === "sequential") return [0, q.high];
    const most = Math.max(-q.low, q.high) || 1;
    return [-most, most];
  }

  // Pixels of the cross-section. The scale along y is stretched where the layer would be too thin to see.
  frame(width) {
    const { window: [left, right], thickness } = this.data, from = 46, to = width - 12, scale = (to - from) / (right - left);
    const stretch = [1, 1.5, 2, 3, 4, 6, 8, 12, 16].find(f => f * thickness * scale >= 92) || 24;
    const tall = thickness * scale * stretch, head = 104;
    return { from, to, scale, stretch, head, tall, x: at => from + (at - left) * scale, y: at => head + (thickness - at) * scale * stretch, height: head + tall + 73 };
  }

  crossSection(width, step) {
    const f = this.frame(width), canvas = this.rubber(width, f, step);
    const node = svg("svg", { width, height: f.height, viewBox: `0 0 ${width} ${f.height}`, role: "img",
      "aria-label": `Cross-section at load step ${step.number}: P ${fixed(step.P, 3)} N/mm, Q ${fixed(step.Q, 3)} N/mm` });
    node.append(svg("clipPath", { id: "stage-clip" }, svg("rect", { x: f.from, y: 0, width: f.to - f.from, height: f.height })));
    const inner = svg("g", { "clip-path": "url(#stage-clip)" });
    node.append(inner, this.millimetres(f));
    inner.append(...this.meshLines(f), this.indenter(f, step), ...this.marks(f, step), ...this.tiles(f, step));
    node.append(...this.arrows(f, step));
    const words = [this.data.exaggeration === 1 ? "displacement true to scale" : `displacement × ${this.data.exaggeration}`, f.stretch === 1 ? "" : `height × ${f.stretch}`].filter(Boolean).join(", ");
    node.append(svgText(f.from + 2, 12, words, { class: "halo" }));
    for (const [k, name] of ["σ_y", "τ_{xy}"].entries()) node.append(svgText(f.from - 7, f.head + f.tall + 20 + 14 * k, name, { "text-anchor": "end" }));
    return [canvas, node];
  }

  // Displaced place of grid point (row, column), in pixels.
  places(f) {
    const { field, thickness, exaggeration } = this.data, ux = this.field(0), uy = this.field(1), points = [];
    for (let j = 0; j < field.rows; ++j)
      for (let i = 0; i < field.columns; ++i) {
        const k = j * field.columns + i, x = field.x[0] + (field.x[1] - field.x[0]) * i / (field.columns - 1), y = thickness * j / (field.rows - 1);
        points.push([f.x(x + exaggeration * ux[k]), f.y(y + exaggeration * uy[k])]);
      }
    return points;
  }
  rubber(width, f, step) {
    const sharp = Math.min(3, devicePixelRatio || 1), canvas = html("canvas", { width: width * sharp, height: f.height * sharp, style: `width:${width}px;height:${f.height}px` });
    const context = canvas.getContext("2d"), { field } = this.data, points = this.places(f), values = this.field(this.quantity), colour = colouring(this.palette(), this.limits());
    context.scale(sharp, sharp);
    context.beginPath();
    context.rect(f.from, 0, f.to - f.from, f.height);
    context.clip();
    const fine = 4, at = (list, j, i, u, v, pick) => {
      const k = j * field.columns + i, c = [k, k + 1, k + field.columns, k + field.columns + 1].map(n => pick(list[n]));
      return (c[0] * (1 - u) + c[1] * u) * (1 - v) + (c[2] * (1 - u) + c[3] * u) * v;
    };
    for (let j = 0; j + 1 < field.rows; ++j)
      for (let i = 0; i + 1 < field.columns; ++i)
        for (let b = 0; b < fine; ++b)
          for (let a = 0; a < fine; ++a) {
            const corner = (u, v) => [at(points, j, i, u, v, p => p[0]), at(points, j, i, u, v, p => p[1])];
            const u = a / fine, v = b / fine, d = 1 / fine, quad = [corner(u, v), corner(u + d, v), corner(u + d, v + d), corner(u, v + d)];
            context.fillStyle = context.strokeStyle = css(colour(at(values, j, i, u + d / 2, v + d / 2, p => p)));
            context.beginPath();
            quad.forEach(([x, y], n) => n ? context.lineTo(x, y) : context.moveTo(x, y));
            context.closePath();
            context.fill();
            context.lineWidth = 0.6;
            context.stroke();
          }
    return canvas;
  }
  meshLines(f) {
    const { field } = this.data, points = this.places(f), lines = [];
    const path = picks => "M" + picks.map(k => points[k].map(v => v.toFixed(1)).join(",")).join("L");
    for (let j = 0; j < field.rows; j += 3) lines.push(path(Array.from({ length: field.columns }, (_, i) => j * field.columns + i)));
    for (let i = 0; i < field.columns; i += 4) lines.push(path(Array.from({ length: field.rows }, (_, j) => j * field.columns + i)));
    const top = path(Array.from({ length: field.columns }, (_, i) => (field.rows - 1) * field.columns + i));
    return [svg("path", { d: lines.join(""), fill: "none", stroke: ink("ink"), "stroke-opacity": 0.2, "stroke-width": 0.7 }),
      svg("path", { d: top, fill: "none", stroke: ink("ink"), "stroke-width": 1.2 })];
  }
  indenter(f, step) {
    const { indenter, thickness, exaggeration } = this.data, ceiling = 30, group = svg("g", {});
    if (!indenter.x.length) return group;
    const place = (x, y) => `${f.x(x + exaggeration * step.tangential).toFixed(1)},${Math.max(ceiling - 400, f.y(thickness + exaggeration * (y - step.indentation))).toFixed(1)}`;
    const outline = indenter.x.map((x, k) => place(x, indenter.y[k]));
    const ends = [indenter.x[indenter.x.length - 1], indenter.x[0]].map(x => `${f.x(x + exaggeration * step.tangential).toFixed(1)},${ceiling}`);
    group.append(svg("clipPath", { id: "head-clip" }, svg("rect", { x: f.from, y: ceiling, width: f.to - f.from, height: f.height })));
    group.append(svg("g", { "clip-path": "url(#head-clip)" }, svg("path", { d: `M${outline.join("L")}L${ends.join("L")}Z`, fill: ink("steel"), "fill-opacity": 0.85, stroke: ink("steel-edge"), "stroke-width": 1.6, "stroke-linejoin": "round" })));
    return group;
  }
  marks(f, step) {
    const { surface_x, thickness, exaggeration } = this.data, out = [], close = surface_x.length > 60;
    surface_x.forEach((x, k) => {
      const status = step.status[k], open = status === "o";
      if (open && close) return;
      const px = f.x(x + exaggeration * step.ux[k]), py = f.y(thickness + exaggeration * step.uy[k]);
      out.push(markNode(statusMark[status], px, py, open ? 2.2 : close ? 2.8 : 4, open ? ink("card") : ink(statusInk[status]), open ? { stroke: ink("grey") } : {}));
    });
    return out;
  }
  // What the tactels under the window measure: tiles below the rubber.
  tiles(f, step) {
    const { tactel_x, tactel_width } = this.data, spacing = tactel_x.length > 1 ? tactel_x[1] - tactel_x[0] : 1;
    const wide = Math.max(3, f.scale * Math.max(tactel_width, 0.72 * spacing)), out = [];
    for (const [k, values] of [step.sigma, step.tau].entries()) {
      const most = this.data.tactel_most[k] || 1, colour = colouring("diverging", [-most, most]);
      tactel_x.forEach((x, i) => {
        const tile = svg("rect", { x: f.x(x) - wide / 2, y: f.head + f.tall + 9 + 14 * k, width: wide, height: 12, rx: 2, fill: css(colour(values[i])), stroke: ink("faint"), "stroke-width": 0.6 });
        tile.append(svg("title", {}, `tactel at ${number(x)} mm: ${["sigma_y", "tau_xy"][k]} ${number(values[i])} MPa`));
        out.push(tile);
      });
    }
    out.push(svg("line", { x1: f.from, x2: f.to, y1: f.head + f.tall + 1, y2: f.head + f.tall + 1, stroke: ink("steel-edge"), "stroke-width": 3 }));
    return out;
  }
  millimetres(f) {
    const group = svg("g", {}), base = f.head + f.tall + 41;
    for (const t of linearTicks(this.data.window, Math.max(3, (f.to - f.from) / 58)))
      group.append(svg("line", { class: "axis", x1: f.x(t.at), x2: f.x(t.at), y1: base - 4, y2: base }), svgText(f.x(t.at), base + 12, t.text, { "text-anchor": "middle" }));
    group.append(svgText((f.from + f.to) / 2, base + 26, "x (mm)", { "text-anchor": "middle" }));
    return group;
  }
  // P and Q in one scale, at the indenter.
  arrows(f, step) {
    const most = Math.max(...this.data.path.P.map(v => Math.abs(v ?? 0)), ...this.data.path.Q.map(v => Math.abs(v ?? 0))) || 1;
    const { position, exaggeration } = this.data, x = Math.min(f.to - 40, Math.max(f.from + 40, f.x(position + exaggeration * step.tangential))), y = 84, out = [];
    const long = value => 52 * value / most;
    const arrow = (x1, y1, x2, y2, colour, label, lx, ly, anchor) => {
      const parts = forceArrow(x1, y1, x2, y2, colour);
      if (parts.length) out.push(...parts, svgText(lx, ly, label, { class: "halo", "text-anchor": anchor, style: `fill:${ink(colour)};font-weight:650` }));
    };
    arrow(x, y - long(step.P), x, y, "blue", `P ${fixed(step.P, 2)} N/mm`, x - 8, Math.max(26, y - long(step.P) + 6), "end");
    const q = long(step.Q);
    arrow(x, y, x + q, y, "purple", `Q ${fixed(step.Q, 2)} N/mm`, q < 0 ? x + q - 6 : x + q + 6, y + 4, q < 0 ? "end" : "start");
    return out;
  }

  // Pressure, shear and the limit of friction over the same x as the cross-section. Of a patch the tractions are
  // constant on each element.
  tractions(width, step) {
    const { surface_x, surface_width, mu, most_traction } = this.data, series = (...its) => along(its[0], surface_x, surface_width, ...its.slice(1));
    const lines = [series("pressure p", step.p, "blue", "line"), series("shear q", step.q, "orange", "long_dashes")];
    if (mu !== null) for (const sign of [1, -1]) lines.push(series(sign > 0 ? "limit ±µp" : "", step.p.map(p => sign * mu * p), "grey", "dashed"));
    const node = tractionPanel({ title: "On the surface", x_label: "x (mm)", y_label: "traction of the indenter on the rubber (MPa)", x_range: this.data.window, y_range: most_traction, width, left: 46, right: 12 },
      lines, surface_x, step.q, step.status);
    const key = legend(lines);
    key.append(...statusLegend().childNodes);
    return html("div", {}, key, node);
  }

  others(width) {
    const columns = width < 560 ? 1 : 2, each = Math.floor((width - 26 * (columns - 1)) / columns), { data } = this, step = data.steps[this.index];
    const line = (label, x, y, colour, mark) => ({ label, x, y, ink: colour, mark, low: [], high: [] });
    const tactels = { title: "What the tactels feel", x_label: "x (mm)", y_label: "stress at the base (MPa)", zero_line: true, y_range: data.tactel_range,
      series: [line("σ_y", data.tactel_x, step.sigma, "blue", "line_dots"), line("τ_{xy}", data.tactel_x, step.tau, "orange", "dash_triangles")] };
    const parts = [html("div", {}, legend(tactels.series), drawPanel(tactels, each, 220, false))];
    if (data.path.number.length > 1) {
      const { number: steps, S, stick } = data.path;
      parts.push(pathPanel("Along the path", "share", steps, [["part that sticks", stick, "green"], ["slippage index S", S, "black"]], step.number, data.path_range, each), ...this.strips(each));
    }
    return html("div", { class: "panels", style: `grid-template-columns:repeat(${columns},minmax(0,1fr));margin-top:.8rem` }, ...parts);
  }
  // All steps at once: a row a load step, a column a tactel. A click goes to the step.
  strips(width) {
    const { data } = this, n = data.steps.length, spacing = data.tactel_x.length > 1 ? data.tactel_x[1] - data.tactel_x[0] : 1;
    const edges = [data.tactel_x[0] - spacing / 2, data.tactel_x.at(-1) + spacing / 2];
    return ["sigma", "tau"].map((key, k) => {
      const raster = { rows: n, columns: data.tactel_x.length, values: data.steps.flatMap(s => s[key]), x_range: edges, y_range: [0.5, n + 0.5], unit: "MPa", palette: "diverging", limits: [-data.tactel_most[k] || -1, data.tactel_most[k] || 1] };
      const every = Math.ceil(n / 8), ticks = data.steps.map((s, i) => [i + 1, String(s.number)]).filter((_, i) => i % every === 0);
      const panel = { title: k ? "τ_{xy} at every tactel and step" : "σ_y at every tactel and step", x_label: "tactel at x (mm)", y_label: "load step", series: [], raster };
      const out = drawPanel({ ...panel, y_range: raster.y_range, x_range: edges }, width, 200, false), node = out.querySelector("svg");
      const axes = makeAxes({ width, height: 200, x: edges, y: raster.y_range, title: panel.title, xLabel: panel.x_label, yLabel: panel.y_label });
      const at = this.index + 1;
      node.append(svg("rect", { x: axes.left, width: axes.right - axes.left, y: axes.y(at + 0.5), height: axes.y(at - 0.5) - axes.y(at + 0.5), fill: "none", stroke: ink("ink"), "stroke-width": 1.5, "pointer-events": "none" }));
      node.style.cursor = "pointer";
      node.addEventListener("click", event => {
        const row = Math.floor((axes.floor - (event.clientY - node.getBoundingClientRect().top)) / (axes.floor - axes.top) * n);
        if (row >= 0 && row < n) this.show(row);
      });
      return out;
    });
  }

  // What can be saved: label of the button, part of the file's name, rows.
  tables() { return [["CSV: surface", "surface", () => this.surfaceRows()], ["tactels", "tactels", () => this.tactelRows()], ["field", "field", () => this.fieldRows()]]; }
  surfaceRows() {
    const rows = [["load step", "indentation (mm)", "tangential (mm)", "P (N/mm)", "Q (N/mm)", "S", "x (mm)", "status", "pressure (MPa)", "shear (MPa)", "u_x (mm)", "u_y (mm)"]];
    for (const s of this.data.steps)
      this.data.surface_x.forEach((x, k) => rows.push([s.number, s.indentation, s.tangential, s.P, s.Q, s.S, x, statusWord[s.status[k]], s.p[k], s.q[k], s.ux[k], s.uy[k]]));
    return rows;
  }
  tactelRows() {
    const rows = [["load step", "x (mm)", "sigma_y (MPa)", "tau_xy (MPa)"]];
    for (const s of this.data.steps) this.data.tactel_x.forEach((x, k) => rows.push([s.number, x, s.sigma[k], s.tau[k]]));
    return rows;
  }
  fieldRows() {
    const { field, thickness, steps } = this.data, rows = [["load step", "x (mm)", "y (mm)", ...field.quantities.map(q => `${plainText(q.name)} (${q.unit})`)]];
    for (const s of steps) {
      const all = field.quantities.map((_, k) => fieldValues(field, s, k));
      for (let k = 0; k < field.rows * field.columns; ++k)
        rows.push([s.number, ...[field.x[0] + (field.x[1] - field.x[0]) * (k % field.columns) / (field.columns - 1), thickness * Math.floor(k / field.columns) / (field.rows - 1), ...all.map(v => v[k])].map(v => parseFloat(v.toPrecision(4)))]);
    }
    return rows;
  }
}
