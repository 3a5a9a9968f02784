// SPDX-License-Identifier: Apache-2.0

// The page of monitor --serve: lines of JSON, as monitor prints them, come as server-sent events; pads or a line, the number that
// the alarm judges over ten seconds, and what is to be known of the stream.

const setup = JSON.parse(document.getElementById("setup").textContent);
const word = { slip_index: "S" }[setup.signal] ?? setup.signal, seconds = 10, padColours = ["blue", "orange", "green", "purple"], padDashes = ["", "11 3", "2 3", "9 3 2 3"];
const history = [];  // lines of the last ten seconds, of each what the chart needs
let line = null, most = 1e-6, mostShear = 1e-6, stopped = "", drift = [], due = false, received = 0, painted = 0;

const byId = id => document.getElementById(id);
const padOf = (of, k) => of.pads ? of.pads[k] : of;
const numberOf = of => setup.signal === "moved" ? of.moved : of.slip_upper ?? of[setup.signal];
const normalsOf = k => { const from = setup.pads.slice(0, k).reduce((sum, pad) => sum + pad.tactels[0] * pad.tactels[1], 0), [nx, ny] = setup.pads[k].tactels; return line.stresses.map(axis => axis.slice(from, from + nx * ny)); };

function state() {
  if (line.alarm) return line.cannot_tell ? ["ALARM", "cannot tell", "poor"] : ["ALARM", setup.signal === "slip_index" ? "slip is near" : "it leaves its hold", "poor"];
  if (line.contact === false) return ["no contact", "", "fact"];
  if (line.cannot_tell) return ["cannot tell", line.rest === false ? "the rest of the grip is sought" : "unlike what was learnt", "fair"];
  return setup.alarm === null ? ["contact", "", "fact"] : ["holds", "", "good"];
}

// A pad from above: y upwards, pressure as the colour of a tile, shear as its arrow.
function drawPad(k) {
  const { tactels: [nx, ny], pitch } = setup.pads[k], [normal, x, y] = normalsOf(k), box = byId(`pad-${k}`), wide = Math.max(160, Math.min(330, box.clientWidth));
  const step = wide / nx, ratio = pitch[0] > 0 ? pitch[1] / pitch[0] : 1, tall = step * ratio * ny, colour = colouring("sequential", [0, most]);
  const node = svg("svg", { width: wide, height: tall, viewBox: `0 0 ${wide} ${tall}`, role: "img", "aria-label": `Stresses of ${setup.pads[k].name}` });
  let shafts = "", heads = "";
  for (let j = 0; j < ny; ++j)
    for (let i = 0; i < nx; ++i) {
      const t = j * nx + i, px = (i + 0.5) * step, py = tall - (j + 0.5) * step * ratio, side = 0.92 * step, value = normal[t];
      node.append(svg("rect", { x: px - side / 2, y: py - side * ratio / 2, width: side, height: side * ratio, rx: Math.min(5, 0.12 * side), fill: value === null ? ink("hair") : css(colour(-value)), stroke: ink("faint"), "stroke-width": 0.7 }));
      if (value === null) node.append(svgText(px, py + 4, "?", { "text-anchor": "middle" }));
      const long = 0.75 * step / mostShear, arrow = x && arrowPaths(px, py, px + long * (x[t] ?? 0), py - long * (y ? y[t] ?? 0 : 0), 8);
      if (arrow) { shafts += arrow.shaft; heads += arrow.head; }
    }
  const stroke = (d, more) => svg("path", { d, fill: "none", ...more });
  node.append(stroke(shafts, { stroke: ink("card"), "stroke-width": 4.4, "stroke-opacity": 0.85 }), svg("path", { d: heads, fill: ink("ink"), stroke: ink("card"), "stroke-width": 1.4, "paint-order": "stroke" }), stroke(shafts, { stroke: ink("ink"), "stroke-width": 1.8 }));
  box.replaceChildren(node);
}

// A line of tactels: pressure upwards and shear as bars.
function drawLine() {
  const [normal, shear] = line.stresses, box = byId("pad-0"), wide = Math.max(240, box.clientWidth), axes = makeAxes({ width: wide, height: 190, x: [0.5, normal.length + 0.5], y: [-most, most], xLabel: "tactel", yLabel: "pressure, shear (MPa)" });
  const node = svg("svg", { width: wide, height: 190, viewBox: `0 0 ${wide} 190`, role: "img", "aria-label": "Stresses of the line" }, axes.node), each = 0.38 * (axes.right - axes.left) / normal.length;
  for (const [side, values, sign, colour] of [[-1, normal, -1, "blue"], [0, shear || [], 1, "orange"]])
    values.forEach((value, i) => {
      const at = axes.y(sign * (value ?? 0)), zero = axes.y(0);
      node.append(svg("rect", { x: axes.x(i + 1) + side * each, y: Math.min(at, zero), width: each, height: Math.abs(at - zero), fill: ink(colour) }));
    });
  box.replaceChildren(node);
}

// What the alarm judges, over time; the truth where a simulation tells it.
function drawHistory() {
  const box = byId("history"), wide = Math.max(240, box.clientWidth), now = history.at(-1).time, span = [now - seconds, now];
  const truth = history.some(h => finite(h.truth)), values = history.flatMap(h => h.values).filter(finite), level = setup.alarm === null ? [] : [setup.alarm];
  const top = truth || setup.signal === "slip_index" ? 1.05 : 1.15 * Math.max(1e-3, ...values, ...level), low = Math.min(0, ...values);
  const axes = makeAxes({ width: wide, height: 230, x: [-seconds, 0], y: [low, top], xLabel: "time (s)", yLabel: word + (setup.bound ? ", its upper bound" : "") + (truth && setup.signal !== "slip_index" ? "; true S" : "") });
  const node = svg("svg", { width: wide, height: 230, viewBox: `0 0 ${wide} 230`, role: "img", style: "overflow:hidden", "aria-label": `${word} over ten seconds` });
  const px = time => axes.x(time - span[1]), path = of => {
    let d = "", drawing = false;
    for (const h of history) {
      const value = of(h);
      if (!finite(value)) { drawing = false; continue; }
      d += `${drawing ? "L" : "M"}${px(h.time).toFixed(1)},${axes.y(value).toFixed(1)}`;
      drawing = true;
    }
    return d;
  };
  for (let i = 0; i < history.length; ++i)
    if (history[i].alarm) node.append(svg("rect", { x: px(history[i].time), y: axes.top, width: Math.max(1.5, px(history[i + 1]?.time ?? now) - px(history[i].time)), height: axes.floor - axes.top, fill: ink("red"), "fill-opacity": 0.16 }));
  node.append(axes.node);
  if (setup.alarm !== null) node.append(svg("line", { x1: axes.left, x2: axes.right, y1: axes.y(setup.alarm), y2: axes.y(setup.alarm), stroke: ink("red"), "stroke-width": 1.3, "stroke-dasharray": "5 4" }));
  const draw = (of, colour, dash) => node.append(svg("path", { d: path(of), fill: "none", stroke: ink(colour), "stroke-width": 2, "stroke-dasharray": dash, "stroke-linejoin": "round" }));
  if (truth) draw(h => h.truth, "grey", "1 3");
  for (let k = 0; k < setup.pads.length; ++k) draw(h => h.values[k], padColours[k % 4], padDashes[k % 4]);
  const key = (text, colour, dash) => html("span", {}, svg("svg", { width: 26, height: 10 }, svg("path", { d: "M0,5H26", fill: "none", stroke: ink(colour), "stroke-width": 2, "stroke-dasharray": dash })), text);
  byId("key").replaceChildren(...setup.pads.map((pad, k) => key(`${word}${setup.pads.length > 1 ? " of " + pad.name : ""}`, padColours[k % 4], padDashes[k % 4])), ...(truth ? [key("true S", "grey", "1 3")] : []), ...(setup.alarm === null ? [] : [key("alarm", "red", "5 4")]));
  box.replaceChildren(node);
}

function drawWords() {
  const [head, why, tone] = state();
  byId("state").className = `state ${tone}`;
  byId("state").replaceChildren(html("b", {}, stopped ? "ended" : head), html("span", {}, stopped || why));
  const read = [[word, fixed(numberOf(line), 3)], ...(setup.alarm === null ? [] : [["alarm from", fixed(setup.alarm, 3)]]),
    ...(line.true_slip_index === undefined ? [] : [["true S", fixed(line.true_slip_index, 3)]]), ["frame", String(line.frame)], ["largest so far", `${number(most, 3)} MPa`], ["answered in", line.latency_us === null ? "–" : `${number(line.latency_us, 2)} µs`]];
  byId("readout").replaceChildren(...read.map(([name, value]) => html("div", {}, name, html("b", {}, value))));
  setup.pads.forEach((pad, k) => {
    const of = padOf(line, k), said = of.contact === false ? "no contact" : `${word} ${fixed(numberOf(of), 3)}`;
    byId(`name-${k}`).replaceChildren(html("b", {}, pad.name), " ", html("span", {}, said));
  });
  byId("drift").replaceChildren(...drift.map(text => html("p", { class: "note" }, text)));
}

function draw() {
  due = false;
  painted = Date.now();
  if (!line) return;
  drawWords();
  setup.pads.forEach((pad, k) => pad.tactels ? drawPad(k) : drawLine());
  drawHistory();
  byId("scale").replaceChildren(...(setup.pads[0].tactels ? [scaleBar("sequential", [0, most], "MPa, pressure"), html("span", {}, `longest arrow ${number(mostShear, 2)} MPa, shear`)] : []));
}

function take(text) {
  line = JSON.parse(text);
  ++received;
  const largest = axes => Math.max(...axes.flat().filter(finite).map(Math.abs), 1e-6);
  most = Math.max(most, largest(setup.pads[0].tactels ? line.stresses.slice(0, 1) : line.stresses));
  mostShear = Math.max(mostShear, largest(line.stresses.slice(1)));
  for (const one of line.drift || []) drift = [...drift, one.text].slice(-4);
  if (history.length && line.arrival < history.at(-1).time) history.length = 0;  // a stream that began again
  history.push({ time: line.arrival, alarm: line.alarm, truth: line.true_slip_index, values: setup.pads.map((_, k) => { const of = padOf(line, k); return of.contact === false ? null : numberOf(of); }) });
  while (history[0].time < line.arrival - seconds) history.shift();
  if (!due) { due = true; requestAnimationFrame(draw); }
}

const stream = new EventSource("events");
stream.onmessage = event => take(event.data);
stream.addEventListener("end", event => { stopped = event.data; stream.close(); if (line) draw(); });
stream.onerror = () => { if (!stopped && line) { byId("state").className = "state fair"; byId("state").replaceChildren(html("b", {}, "no stream"), html("span", {}, "monitor has ended, or cannot be reached")); } };
addEventListener("resize", draw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
window.tactel = { shown: () => ({ line, most, history, received, painted: due ? 0 : painted }) };  // for tests and the console
