// Panels for paper: SVG made at once when the page is printed (a canvas would come too late, and in the screen's theme).
"use strict";

const PAPER = {width: 520, height: 230, left: 62, right: 10, top: 8, bottom: 36};

function svgPlot(spec, hidden, range) {
  const [x0, x1, y0, y1] = range;
  const {width, height, left, right, top, bottom} = PAPER;
  const along = spec.log ? Math.log10 : (x) => x;
  const px = (x) => left + (width - left - right) * (along(x) - along(x0)) / (along(x1) - along(x0));
  const py = (y) => top + (height - top - bottom) * (y1 - y) / (y1 - y0);
  const near = (y) => Math.min(Math.max(py(y), -height), 2 * height);
  const clip = `clip-${spec.key}`;
  const inner = `x="${left}" y="${top}" width="${width - left - right}" height="${height - top - bottom}"`;
  const shown = spec.series.filter((_, index) => !hidden[index]);
  return `<svg class="paper" viewBox="0 0 ${width} ${height}" aria-hidden="true">`
    + `<clipPath id="${clip}"><rect ${inner}></rect></clipPath>${axes(spec, range, px, py)}`
    + `<g clip-path="url(#${clip})">${shown.map((series) => drawn(series, px, near)).join("")}</g>`
    + `<rect ${inner} class="frame"></rect></svg>`;
}

function drawn(series, px, py) {
  const colour = `var(--c-${series.colour})`;
  const pattern = series.kind === "level" ? [5, 4] : series.dash || [];
  const dash = pattern.length ? ` stroke-dasharray="${pattern.join(" ")}"` : "";
  const stroke = `fill="none" stroke="${colour}" stroke-width="${series.wide ? 2.6 : 1.2}"${dash}`;
  if (series.kind === "level") {
    return series.y.map((y) => `<path ${stroke} d="M0 ${py(y).toFixed(1)}h${PAPER.width}"></path>`).join("");
  }
  if (series.kind === "bars") return bars(series, px, py, colour);
  const points = (value) => trace(series.x, value, px, py);
  let band = "";
  if (series.half) {
    const low = trace(series.x, edge(series, -1), px, py), high = trace(series.x, edge(series, 1), px, py).reverse();
    band = `<path fill="${colour}" fill-opacity="0.18" d="M${low.concat(high).join("L")}z"></path>`;
  }
  return `${band}<path ${stroke} d="M${points(series.y).join("L")}"></path>`;
}

function bars(series, px, py, colour) {
  const width = px(series.width) - px(0);
  const rects = Array.from(series.x, (x, index) => {
    const [a, b] = [py(0), py(series.y[index])];
    return `<rect x="${(px(x) - width / 2).toFixed(1)}" y="${Math.min(a, b).toFixed(1)}" width="${width.toFixed(1)}"`
      + ` height="${Math.abs(a - b).toFixed(1)}"></rect>`;
  });
  return `<g fill="${colour}" fill-opacity="0.75">${rects.join("")}</g>`;
}

// Points of a curve, at most two for each half pixel, so that a page of many panels stays small.
function trace(xs, ys, px, py) {
  const points = [];
  let last = "";
  for (let index = 0; index < xs.length; index++) {
    if (Number.isNaN(ys[index])) continue;
    const point = `${(Math.round(2 * px(xs[index])) / 2)} ${py(ys[index]).toFixed(1)}`;
    if (point !== last) points.push(point);
    last = point;
  }
  return points.length ? points : ["0 0"];
}

function axes(spec, [x0, x1, y0, y1], px, py) {
  const {width, height, left, right, bottom} = PAPER;
  const base = height - bottom;
  const x = (spec.log ? decades(x0, x1) : ticks(x0, x1, 6)).map((value) =>
    `<path class="grid" d="M${px(value)} ${PAPER.top}V${base}"></path><text x="${px(value)}" y="${base + 14}" text-anchor="middle">${tickText(value)}</text>`);
  const y = ticks(y0, y1, 4).map((value) =>
    `<path class="grid" d="M${left} ${py(value)}H${width - right}"></path><text x="${left - 6}" y="${py(value) + 4}" text-anchor="end">${tickText(value)}</text>`);
  const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  const middle = (PAPER.top + base) / 2;
  return x.join("") + y.join("")
    + `<text x="${(left + width - right) / 2}" y="${height - 5}" text-anchor="middle">${escaped(spec.x)}</text>`
    + `<text transform="translate(11 ${middle}) rotate(-90)" text-anchor="middle">${escaped(spec.y)}</text>`;
}

function ticks(low, high, wanted) {
  const raw = (high - low) / wanted;
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const first = Math.ceil(low / step), last = Math.floor(high / step);
  return Array.from({length: last - first + 1}, (_, k) => (first + k) * step);
}

function decades(low, high) {
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  const powers = Array.from({length: last - first + 1}, (_, k) => 10 ** (first + k));
  return powers.flatMap((p) => [1, 2, 5].map((m) => m * p)).filter((value) => value >= low && value <= high);
}

function tickText(value) {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}
