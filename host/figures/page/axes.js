// SPDX-License-Identifier: Apache-2.0

// Ranges, ticks and axes of a panel.

// Positions at a distance of 1, 2 or 5 times a power of ten, `most` at most.
function linearTicks([low, high], most) {
  const rough = (high - low) / Math.max(1, most), power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= rough * (1 - 1e-9));
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push(k * step);
  return ticks.map(t => ({ at: t, text: number(parseFloat(t.toPrecision(12))) }));
}
function logTicks([low, high], most) {
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  const every = Math.max(1, Math.ceil((last - first) / most)), ticks = [];
  const factors = last - first <= 3 ? [1, 2, 5] : [1];
  for (let e = first; e <= last; ++e)
    for (const f of factors) {
      const at = f * 10 ** e;
      if ((e - first) % every || at < low * (1 - 1e-9) || at > high * (1 + 1e-9)) continue;
      ticks.push({ at, text: e < -3 || e > 4 ? (f > 1 ? f + "·" : "") + `10^{${String(e).replace("-", "−")}}` : number(at) });
    }
  return ticks.length > 2 || high > 5 * low ? ticks : linearTicks([low, high], most);
}

// The range of numbers, with room around them.
function rangeOf(values, given, log, room) {
  if (given) return given;
  const good = values.filter(v => v !== null && v !== undefined && isFinite(v) && (!log || v > 0));
  if (!good.length) return log ? [0.1, 1] : [0, 1];
  let low = good.reduce((a, b) => Math.min(a, b)), high = good.reduce((a, b) => Math.max(a, b));
  if (log) return low === high ? [low / 2, high * 2] : [low / (high / low) ** room, high * (high / low) ** room];
  if (low === high) { low -= Math.abs(low) * 0.1 || 0.5; high += Math.abs(high) * 0.1 || 0.5; }
  return [low - room * (high - low), high + room * (high - low)];
}

function makeScale([low, high], [from, to], log) {
  const f = log ? Math.log : v => v, a = f(low), b = f(high);
  const scale = value => from + (to - from) * (f(value) - a) / (b - a);
  scale.range = [low, high];
  scale.pixels = [from, to];
  scale.log = log;
  return scale;
}

const textWidth = text => 6.9 * pieces(String(text)).reduce((sum, p) => sum + p.text.length * (p.place ? 0.8 : 1), 0);

// Axes of a panel: places, then grid, ticks and labels. Returns scales and the node.
function makeAxes({ width, height, x, y, title, xLabel, yLabel, xTicks, logX, logY, right = 10, left: leftGiven }) {
  const tall = height - 70;
  const yTicks = logY ? logTicks(y, Math.max(3, tall / 30)) : linearTicks(y, Math.max(3, Math.min(8, tall / 26)));
  let left = leftGiven ?? Math.ceil(Math.max(...yTicks.map(t => textWidth(t.text)), 8)) + 10;
  const top = (title ? 20 : 4) + (yLabel ? 17 : 4) + 4;
  let inner = width - left - right;
  const named = Boolean(xTicks && xTicks.length);
  const all = named ? xTicks.map(([at, text]) => ({ at, text })) : logX ? logTicks(x, inner / 60) : linearTicks(x, Math.max(2, Math.min(10, inner / 58)));
  const slot = named ? Math.abs(inner * (all.length > 1 ? all[1].at - all[0].at : 1) / (x[1] - x[0])) : 1e9;
  const place = at => (at - x[0]) / (x[1] - x[0]) * inner, half = t => textWidth(t.text) / 2;
  const tilted = named && all.some(t => 2 * half(t) > slot - 4 || half(t) > inner + right - place(t.at));
  if (tilted) {  // names end below their tick: room for the first ones at the left
    left = Math.max(left, ...all.map(t => 1.64 * half(t) - place(t.at)));
    inner = width - left - right;
  }
  const longest = Math.max(...all.map(t => textWidth(t.text)), 0);
  const bottom = (tilted ? Math.min(90, 12 + 0.57 * longest) : 20) + (xLabel ? 18 : 4);
  const xScale = makeScale(x, [left, width - right], logX), yScale = makeScale(y, [height - bottom, top], logY);
  const node = svg("g", {});
  if (title) node.append(svgText(0, 13, title, { class: "title" }));
  if (yLabel) node.append(svgText(0, (title ? 20 : 4) + 11, yLabel, { class: "label" }));
  for (const t of yTicks) {
    const at = yScale(t.at);
    node.append(svg("line", { class: "grid", x1: left, x2: width - right, y1: at, y2: at }),
      svgText(left - 7, at + 4, t.text, { "text-anchor": "end" }));
  }
  const floor = height - bottom;
  for (const t of all) {
    const at = xScale(t.at);
    if (!(at > left - 1 && at < width - right + 1)) continue;
    if (!named) node.append(svg("line", { class: "grid", x1: at, x2: at, y1: top, y2: floor }));
    node.append(tilted
      ? svgText(0, 0, t.text, { transform: `translate(${at + 4},${floor + 13}) rotate(-35)`, "text-anchor": "end" })
      : svgText(at, floor + 16, t.text, { "text-anchor": "middle" }));
  }
  node.append(svg("line", { class: "axis", x1: left, x2: width - right, y1: floor, y2: floor }));
  if (xLabel) node.append(svgText((left + width - right) / 2, height - 4, xLabel, { class: "label", "text-anchor": "middle" }));
  return { node, x: xScale, y: yScale, left, right: width - right, top, floor };
}
