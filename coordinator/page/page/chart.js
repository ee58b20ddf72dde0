// The loss by iteration, with a band of one standard error, as SVG of the width that there is.

import { at, row, rows, say, svg } from "./table.js";
import { plural, significant } from "./text.js";

const HEIGHT = 260;
const SPACE = { left: 56, right: 12, top: 14, bottom: 40 };

// Round steps, about `wanted` of them between two numbers.
function ticks(low, high, wanted) {
  const rough = (high - low) / Math.max(wanted, 1) || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough * 0.999);
  const list = [];
  for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + step * 1e-9; t += step) list.push(t);
  return list;
}

function decades(low, high) {
  const list = [];
  const wide = Math.log10(high / low) > 2.5;
  for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e += 1) {
    for (const f of wide ? [1] : [1, 2, 5]) {
      const t = f * 10 ** e;
      if (t >= low && t <= high) list.push(t);
    }
  }
  return list;
}

// How losses and iterations become places.
function axes(points, width) {
  const highest = Math.max(...points.map((p) => p.loss + p.error));
  const lowest = Math.min(...points.map((p) => p.loss));
  const logarithmic = lowest > 0 && highest / lowest > 20;
  let [low, high] = logarithmic
    ? [Math.min(lowest, 1) / 1.15, highest * 1.15]
    : [Math.min(...points.map((p) => p.loss - p.error), 0.95), Math.max(highest, 1.05)];
  if (!logarithmic) {
    const air = 0.06 * (high - low);
    [low, high] = [low - air, high + air];
  }
  const scale = logarithmic ? Math.log : (x) => x;
  const [a, b] = [scale(low), scale(high)];
  const last = Math.max(2, points.at(-1).iteration);
  const [right, bottom] = [width - SPACE.right, HEIGHT - SPACE.bottom];
  return {
    right,
    bottom,
    last,
    logarithmic,
    x: (i) => SPACE.left + ((i - 1) / (last - 1)) * (right - SPACE.left),
    // Below the axis of a logarithm there is nothing: a band may reach there.
    y: (v) => bottom - ((scale(logarithmic ? Math.max(v, low) : v) - a) / (b - a)) * (bottom - SPACE.top),
    ticks: logarithmic ? decades(low, high) : ticks(low, high, 5),
  };
}

function frame(axis) {
  const parts = [];
  for (const t of axis.ticks) {
    const y = axis.y(t).toFixed(1);
    parts.push(svg("path", { class: "grid", d: `M${SPACE.left} ${y}H${axis.right}` }));
    parts.push(svg("text", { x: SPACE.left - 8, y, "text-anchor": "end", dy: "0.32em" }, String(Number(t.toPrecision(4)))));
  }
  const wanted = Math.min(axis.last - 1, Math.floor((axis.right - SPACE.left) / 60));
  for (const t of ticks(1, axis.last, wanted).filter((t) => Number.isInteger(t))) {
    parts.push(svg("text", { x: axis.x(t).toFixed(1), y: axis.bottom + 16, "text-anchor": "middle" }, String(t)));
  }
  const middle = (SPACE.left + axis.right) / 2;
  parts.push(svg("text", { x: middle, y: HEIGHT - 6, "text-anchor": "middle" }, "iteration"));
  const one = axis.y(1).toFixed(1);
  parts.push(svg("path", { class: "right", d: `M${SPACE.left} ${one}H${axis.right}` }));
  return parts;
}

function draw(points, width) {
  const axis = axes(points, width);
  const place = (p, loss) => `${axis.x(p.iteration).toFixed(1)},${axis.y(loss).toFixed(1)}`;
  const upper = points.map((p) => place(p, p.loss + p.error));
  const lower = points.map((p) => place(p, p.loss - p.error)).reverse();
  const parts = frame(axis);
  parts.push(svg("polygon", { class: "band", points: [...upper, ...lower].join(" ") }));
  parts.push(svg("polyline", { class: "curve", points: points.map((p) => place(p, p.loss)).join(" ") }));
  if (points.length <= 80) {
    for (const p of points) {
      const [cx, cy] = place(p, p.loss).split(",");
      const text = `iteration ${p.iteration}: ${significant(p.loss, 5)} \u00b1 ${significant(p.error, 2)}`;
      parts.push(svg("circle", { class: p.accepted ? "point" : "point refused", cx, cy, r: 3.5 }, svg("title", {}, text)));
    }
  }
  return { parts, logarithmic: axis.logarithmic };
}

let shown = [];

function redraw() {
  const figure = at("loss-figure");
  const width = Math.floor(figure.clientWidth);
  if (!shown.length || width < 100) return;
  const { parts, logarithmic } = draw(shown, width);
  const last = shown.at(-1);
  const label = `Loss after ${plural(last.iteration, "iteration")}: from ${significant(shown[0].loss, 4)} to `
    + `${significant(last.loss, 4)}, standard error ${significant(last.error, 2)}. 1 is the loss of a right model.`;
  const chart = at("loss-chart");
  chart.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
  chart.setAttribute("height", HEIGHT);
  chart.setAttribute("aria-label", label);
  chart.replaceChildren(...parts);
  const scale = logarithmic ? "Logarithmic scale. " : "";
  say(at("loss-caption"), `${scale}Band: \u00b1 one standard error of the render's noise. Dashed: a right model, 1. Hollow: a step that was refused.`);
}

export function showLoss(iterations) {
  shown = Object.entries(iterations).map(([i, p]) => ({ iteration: Number(i), ...p }));
  redraw();
  rows(at("loss-rows"), shown.map((p) => [String(p.iteration), p]), () => row("", "number", "number", "number", ""), (tr, p) => {
    const texts = [String(p.iteration), significant(p.loss, 6), significant(p.error, 2), String(p.samples), p.accepted ? "taken" : "refused"];
    texts.forEach((text, i) => say(tr.children[i], text));
  });
}

// The course of one number over the iterations, for the eye alone: the table beside it has the values.
export function spark(values) {
  const [width, height] = [96, 24];
  const picture = svg("svg", { class: "spark", viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" });
  if (values.length < 2) return picture;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const x = (i) => 2 + (i / (values.length - 1)) * (width - 6);
  const y = (v) => (high > low ? height - 3 - ((v - low) / (high - low)) * (height - 6) : height / 2);
  const places = values.map((v, i) => `${x(i).toFixed(1)},${y(v).toFixed(1)}`);
  const [cx, cy] = places.at(-1).split(",");
  picture.append(svg("polyline", { points: places.join(" ") }), svg("circle", { cx, cy, r: 2.5 }));
  return picture;
}

new ResizeObserver(redraw).observe(at("loss-figure"));
