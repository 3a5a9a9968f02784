// SPDX-License-Identifier: Apache-2.0

// The page of monitor --serve: lines of JSON, as monitor prints them, come as server-sent events; pads or a line, the number that
// the alarm judges over ten seconds, and what is to be known of the stream. It is grey where nothing comes.

const setup = JSON.parse(document.getElementById("setup").textContent), judged = setup.alarm !== null;
const word = { slip_index: "S" }[setup.signal] ?? setup.signal, seconds = 10, padColours = ["blue", "orange", "green", "purple"], padDashes = ["", "11 3", "2 3", "9 3 2 3"];
const near = 0.75;  // of the alarm: from here on it is not called below
const history = [];  // lines of the last ten seconds, of each what the pictures need
let line = null, stopped = "", drift = [], due = false, received = 0, painted = 0;
let came = 0, usual = 30, silence = 0, grey = false, released = false;  // ms: of the last line, between two; s of the sensor's silence

const byId = id => document.getElementById(id);
const padOf = (of, k) => of.pads ? of.pads[k] : of;
const numberOf = of => of[setup.bound ? "slip_upper" : setup.signal];
const share = value => judged && finite(value) ? value / setup.alarm : value;  // of the alarm
const normalsOf = k => { const from = setup.pads.slice(0, k).reduce((sum, pad) => sum + pad.tactels[0] * pad.tactels[1], 0), [nx, ny] = setup.pads[k].tactels; return line.stresses.map(axis => axis.slice(from, from + nx * ny)); };
const largestOf = axes => Math.max(1e-6, ...axes.flat().filter(finite).map(Math.abs));
// The next of 1, 1.5, 2, 3, 5, 7 times a power of ten: a scale that holds still, and falls when a spike has left.
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.5, 2, 3, 5, 7, 10].find(step => step * power >= value * (1 - 1e-9));
}
const scaleOf = key => roundUp(Math.max(1e-6, ...history.map(h => h[key])));

// A head, its reason, and a tone. A word says no more than its number does.
function state() {
  const held = line && line.alarm ? "; the alarm is on since before" : "";
  if (stopped) return ["ended", stopped, "fact"];
  if (grey && stream.readyState !== EventSource.OPEN) return ["no stream", "monitor has ended, or cannot be reached" + held, "fact"];
  if (grey && silence) return ["no answer", `the sensor is silent, for ${silence.toFixed(0)} s` + held, "fact"];
  if (grey) return ["no answer", "no line from monitor: the sensor, monitor or the network is still" + held, "fact"];
  if (line.alarm) return line.cannot_tell ? ["ALARM", line.why ?? "cannot tell", "poor"] : ["ALARM", setup.signal === "slip_index" ? "slip is near" : "it leaves its hold", "poor"];
  if (line.contact === false) return [released ? "released" : "no contact", released ? "the hand opened" : "", "fact"];
  if (line.cannot_tell) return ["cannot tell", line.why ?? (line.rest === false ? "the rest of the grip is sought" : "unlike what was learnt"), "fair"];
  const value = numberOf(line);
  if (!finite(value)) return ["no answer", "", "fair"];
  if (!judged) return ["contact", "", "fact"];
  const part = `${word} is ${fixed(100 * share(value), 0)} % of it`;
  if (share(value) >= 1) return ["above the alarm", part + ", and not yet an alarm", "fair"];
  return share(value) < near ? ["below the alarm", part, "good"] : ["near the alarm", part, "fair"];
}

// A pad from above: y upwards, pressure as the colour of a tile, shear as its arrow.
function drawPad(k) {
  const { tactels: [nx, ny], pitch } = setup.pads[k], [normal, x, y] = normalsOf(k), box = byId(`pad-${k}`), wide = Math.max(120, Math.min(330, box.clientWidth));
  const most = scaleOf("most"), mostShear = scaleOf("shear"), step = wide / nx, ratio = pitch[0] > 0 ? pitch[1] / pitch[0] : 1, tall = step * ratio * ny, colour = colouring("sequential", [0, most]);
  const reach = 0.25 * step;  // of an arrow beyond the outer tiles
  const node = svg("svg", { width: wide, height: tall, viewBox: `0 0 ${wide} ${tall}`, style: `margin-top:${reach}px`, role: "img", "aria-label": `Stresses of ${setup.pads[k].name}` });
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
  const [normal, shear] = line.stresses, box = byId("pad-0"), wide = Math.max(240, box.clientWidth), most = Math.max(scaleOf("most"), scaleOf("shear")), axes = makeAxes({ width: wide, height: 190, x: [0.5, normal.length + 0.5], y: [-most, most], xLabel: "tactel", yLabel: "pressure, shear (MPa)" });
  const node = svg("svg", { width: wide, height: 190, viewBox: `0 0 ${wide} 190`, role: "img", "aria-label": "Stresses of the line" }, axes.node), each = 0.38 * (axes.right - axes.left) / normal.length;
  for (const [side, values, sign, colour] of [[-1, normal, -1, "blue"], [0, shear || [], 1, "orange"]])
    values.forEach((value, i) => {
      const at = axes.y(sign * (value ?? 0)), zero = axes.y(0);
      node.append(svg("rect", { x: axes.x(i + 1) + side * each, y: Math.min(at, zero), width: each, height: Math.abs(at - zero), fill: ink(colour) }));
    });
  box.replaceChildren(node);
}

// Curves over ten seconds. of: of an entry of the history one value a curve; curves: name, colour and dash of each.
function drawCurves(box, height, y, yLabel, curves, of, marks) {
  const wide = Math.max(240, box.clientWidth), now = history.at(-1).time;
  const axes = makeAxes({ width: wide, height, x: [-seconds, 0], y, xLabel: "time (s)", yLabel, left: judged ? 36 : undefined });
  const node = svg("svg", { width: wide, height, viewBox: `0 0 ${wide} ${height}`, role: "img", style: "overflow:hidden", "aria-label": `${yLabel} over ten seconds` });
  const px = time => axes.x(time - now), path = k => {
    let d = "", drawing = false;
    for (const h of history) {
      const value = of(h)[k];
      if (!finite(value)) { drawing = false; continue; }
      d += `${drawing ? "L" : "M"}${px(h.time).toFixed(1)},${axes.y(Math.min(value, y[1])).toFixed(1)}`;
      drawing = true;
    }
    return d;
  };
  if (marks)
    history.forEach((h, i) => {
      if (h.alarm) node.append(svg("rect", { x: px(h.time), y: axes.top, width: Math.max(1.5, px(history[i + 1]?.time ?? now) - px(h.time)), height: axes.floor - axes.top, fill: ink("red"), "fill-opacity": 0.16 }));
    });
  node.append(axes.node);
  if (marks && judged) node.append(svg("line", { x1: axes.left, x2: axes.right, y1: axes.y(1), y2: axes.y(1), stroke: ink("red"), "stroke-width": 1.3, "stroke-dasharray": "5 4" }));
  curves.forEach(({ colour, dash }, k) => node.append(svg("path", { d: path(k), fill: "none", stroke: ink(colour), "stroke-width": 2, "stroke-dasharray": dash, "stroke-linejoin": "round" })));
  box.replaceChildren(node);
}

// What the alarm judges, over the alarm, so that the axis holds still; the truth of a simulation below.
function drawHistory() {
  const values = history.flatMap(h => h.values).filter(finite).map(share), truth = history.some(h => finite(h.truth)), of_s = setup.signal === "slip_index";
  const top = judged ? Math.max(1.5, roundUp(Math.max(1e-3, ...values))) : of_s ? 1.05 : roundUp(Math.max(1e-3, ...values)), low = Math.min(0, ...values);
  const names = setup.pads.map((pad, k) => ({ text: `${word}${setup.pads.length > 1 ? " of " + pad.name : ""}`, colour: padColours[k % 4], dash: padDashes[k % 4] }));
  const true_s = { text: "true S", colour: "grey", dash: "1 3" };
  const label = word + (setup.bound ? ", its upper bound" : "") + (judged ? "; 1 is the alarm" : "");
  drawCurves(byId("history"), 230, [low, top], label, [...(truth && of_s ? [true_s] : []), ...names], h => [...(truth && of_s ? [share(h.truth)] : []), ...h.values.map(share)], true);
  const keys = [...names, ...(truth ? [true_s] : []), ...(judged ? [{ text: "alarm", colour: "red", dash: "5 4" }] : [])];
  byId("key").replaceChildren(...keys.map(({ text, colour, dash }) => html("span", {}, svg("svg", { width: 26, height: 10 }, svg("path", { d: "M0,5H26", fill: "none", stroke: ink(colour), "stroke-width": 2, "stroke-dasharray": dash })), text)));
  if (truth && !of_s) drawCurves(byId("truth"), 130, [0, 1.05], "true S", [true_s], h => [h.truth], false);
}

function drawState() {
  const [head, why, tone] = state();
  byId("state").className = `state ${tone}`;
  byId("state").replaceChildren(html("b", {}, head), html("span", {}, why));
  document.querySelector(".live").classList.toggle("silent", grey || stopped !== "");
}

function drawWords() {
  const read = [[word, fixed(numberOf(line), 3)], ...(judged ? [["alarm from", fixed(setup.alarm, 3)]] : []),
    ...(line.true_slip_index === undefined ? [] : [["true S", fixed(line.true_slip_index, 3)]]), ["frame", String(line.frame)], ["largest in 10 s", `${number(Math.max(...history.map(h => h.most)), 2)} MPa`], ["answered in", line.latency_us === null ? "–" : `${number(line.latency_us, 2)} µs`]];
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
  drawState();
  drawWords();
  setup.pads.forEach((pad, k) => pad.tactels ? drawPad(k) : drawLine());
  drawHistory();
  byId("scale").replaceChildren(...(setup.pads[0].tactels ? [scaleBar("sequential", [0, scaleOf("most")], "MPa, pressure"), html("span", {}, `longest arrow ${number(scaleOf("shear"), 2)} MPa, shear`)] : []));
}

function take(text) {
  line = JSON.parse(text);
  ++received;
  const now = performance.now();
  if (came) usual += 0.1 * (Math.min(now - came, 2000) - usual);
  came = now, silence = 0, grey = false;
  released = line.released === true || (released && line.contact === false);
  for (const one of line.drift || []) drift = [...drift, one.text].slice(-4);
  if (history.length && line.arrival < history.at(-1).time) history.length = 0;  // a stream that began again
  history.push({ time: line.arrival, alarm: line.alarm, truth: line.true_slip_index, most: largestOf(line.stresses.slice(0, 1)), shear: largestOf(line.stresses.slice(1)),
    values: setup.pads.map((_, k) => { const of = padOf(line, k); return of.contact === false ? null : numberOf(of); }) });
  while (history[0].time < line.arrival - seconds) history.shift();
  if (!due) { due = true; requestAnimationFrame(draw); }
}

// Half a second without a line, or three times the usual pause, is no answer.
function listen() {
  if (!line || stopped || performance.now() - came < Math.max(500, 3 * usual)) return;
  grey = true;
  drawState();
}

const stream = new EventSource("events");
stream.onmessage = event => take(event.data);
stream.addEventListener("silence", event => {
  silence = JSON.parse(event.data).seconds;
  if (line) return listen();
  byId("state").replaceChildren(html("b", {}, "waiting"), html("span", {}, `for the first frame, for ${silence.toFixed(0)} s: is the sensor on?`));
});
stream.addEventListener("end", event => { stopped = event.data; stream.close(); if (line) draw(); });
setInterval(listen, 100);
addEventListener("resize", draw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
window.tactel = { shown: () => ({ line, most: line && scaleOf("most"), history, received, painted: due ? 0 : painted }) };  // for tests and the console
