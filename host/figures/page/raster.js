// SPDX-License-Identifier: Apache-2.0

// Colours of values, maps on a canvas, and lines of equal value.

const stops = {
  diverging: [["#1b4b96", "#6ba1d6", "#f5f4f0", "#e88f6c", "#a11d22"], ["#86c1ff", "#2e62a6", "#1f242b", "#a44e30", "#ffab8c"]],
  sequential: [["#f8f5ee", "#f1c573", "#d76f3d", "#8d2048", "#360d3c"], ["#1f242b", "#5a2b63", "#b5465c", "#f19354", "#fff1b5"]],
  status: [["#e3e4e2", "#12907a", "#cf4a3c"], ["#2c343e", "#2fb89a", "#f2776d"]],
};
const dark = () => matchMedia("(prefers-color-scheme: dark)").matches && !matchMedia("print").matches;
const channels = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16));

// [r, g, b] of a value between limits.
function colouring(palette, [low, high]) {
  const colours = stops[palette][dark() ? 1 : 0].map(channels), last = colours.length - 1;
  return value => {
    const at = Math.min(last, Math.max(0, last * (value - low) / (high - low || 1)));
    const i = Math.min(last - 1, Math.floor(at)), f = at - i;
    return colours[i].map((c, k) => Math.round(c + f * (colours[i + 1][k] - c)));
  };
}
const css = rgb => `rgb(${rgb.join(",")})`;

function limitsOf(values, palette, given) {
  if (given) return given;
  if (palette === "status") return [0, 2];
  const good = values.filter(v => v !== null && isFinite(v));
  const low = good.reduce((a, b) => Math.min(a, b), 0), high = good.reduce((a, b) => Math.max(a, b), 0);
  if (palette !== "diverging") return [low, high || 1];
  const most = Math.max(-low, high) || 1;
  return [-most, most];
}

// A strip of colours with its ends, unit beside it.
function scaleBar(palette, [low, high], unit, clipped) {
  const colour = colouring(palette, [low, high]);
  const parts = Array.from({ length: 13 }, (_, k) => css(colour(low + (high - low) * k / 12)));
  return html("div", { class: "scalebar" }, html("span", {}, (clipped ? "≤ " : "") + number(low, 3)),
    html("i", { style: `background:linear-gradient(90deg,${parts.join(",")})` }), html("span", {}, (clipped ? "≥ " : "") + number(high, 3)), html("span", {}, ...richHtml(unit || "")));
}

// Segments [x1, y1, x2, y2] in grid units on which values [rows, columns] equal a level (marching squares; a saddle is
// cut by the mean of its corners).
function isoline(values, rows, columns, level) {
  const out = [];
  for (let j = 0; j + 1 < rows; ++j)
    for (let i = 0; i + 1 < columns; ++i) {
      const corner = [values[j * columns + i], values[j * columns + i + 1], values[(j + 1) * columns + i + 1], values[(j + 1) * columns + i]];
      if (corner.some(v => v === null)) continue;
      const above = corner.map(v => v > level), cut = [];
      const spots = [[0, 0], [1, 0], [1, 1], [0, 1]];
      for (let k = 0; k < 4; ++k) {
        const n = (k + 1) % 4;
        if (above[k] === above[n]) continue;
        const f = (level - corner[k]) / (corner[n] - corner[k]);
        cut.push([i + spots[k][0] + f * (spots[n][0] - spots[k][0]), j + spots[k][1] + f * (spots[n][1] - spots[k][1])]);
      }
      const joined = corner.reduce((a, b) => a + b, 0) / 4 > level === above[0];
      if (cut.length === 2) out.push([...cut[0], ...cut[1]]);
      if (cut.length === 4) for (const [a, b] of joined ? [[0, 1], [2, 3]] : [[3, 0], [1, 2]]) out.push([...cut[a], ...cut[b]]);
    }
  return out;
}

// The picture of a raster as a data URL: one pixel a value, first row below.
function rasterImage(raster, limits) {
  const canvas = html("canvas", { width: raster.columns, height: raster.rows }), context = canvas.getContext("2d");
  const image = context.createImageData(raster.columns, raster.rows), colour = colouring(raster.palette, limits);
  raster.values.forEach((value, k) => {
    if (value === null) return;
    const row = raster.rows - 1 - Math.floor(k / raster.columns);
    image.data.set([...colour(value), 255], 4 * (row * raster.columns + k % raster.columns));
  });
  context.putImageData(image, 0, 0);
  return canvas.toDataURL();
}

function drawRaster(raster, axes) {
  const limits = limitsOf(raster.values, raster.palette, raster.limits), group = svg("g", {});
  const [left, right] = raster.x_range.map(axes.x), [bottom, top] = raster.y_range.map(axes.y);
  group.append(svg("image", {
    href: rasterImage(raster, limits), x: left, y: top, width: right - left, height: bottom - top, preserveAspectRatio: "none",
    style: raster.isolines ? "" : "image-rendering:pixelated",
  }));
  if (raster.isolines) {
    const [low, high] = limitsOf(raster.values, "sequential"), path = [];
    const x = i => left + (i + 0.5) / raster.columns * (right - left), y = j => bottom - (j + 0.5) / raster.rows * (bottom - top);
    for (let k = 1; k < raster.isolines; ++k)
      for (const [a, b, c, d] of isoline(raster.values, raster.rows, raster.columns, low + (high - low) * k / raster.isolines))
        path.push(`M${x(a).toFixed(1)},${y(b).toFixed(1)}L${x(c).toFixed(1)},${y(d).toFixed(1)}`);
    group.append(svg("path", { d: path.join(""), fill: "none", stroke: ink("ink"), "stroke-opacity": 0.45, "stroke-width": 0.7 }));
  }
  return { node: group, limits };
}
