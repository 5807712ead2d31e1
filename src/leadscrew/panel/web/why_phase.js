/** Sliding mode: the phase plane with the sliding surface, the boundary layer and where the error has been. */

import { Picture, Span, scale, tickText, ticks } from "./drawing.js";
import { button, make } from "./elements.js";
import { unit, withUnit } from "./format.js";

export const READ =
  "The dot is the error now, the tail where it was in the last seconds. The controller pushes it onto the straight " +
  "line (the sliding surface) and along it to the middle, where there is no error. Inside the shaded band (the " +
  "boundary layer) it pushes gently; outside it pushes with full force. A dot that jumps from side to side of " +
  "the band is chattering.";

const TRAIL_S = 2;
const MOST = 3000; // points of the tail

/** The coordinate of an axis at rows that the page holds: the sum of its terms, each a column and a factor. */
function along(history, axis) {
  const terms = axis.terms ?? (axis.signal ? [[axis.signal, 1]] : []);
  if (!terms.length || terms.some(([name]) => !history.rings.has(name))) return null;
  return (serial) => terms.reduce((sum, [name, factor]) => sum + factor * history.value(name, serial), 0);
}

/**
 * Where both coordinates were over the last seconds, from the rows that the page holds; null where it lacks a column.
 * Thinned rows come in pairs, least and greatest of each column alone: drawn from the one rate to the other at the
 * middle of the errors, so that chattering between them is as wide as it is.
 */
export function trailOf({ history, machine }, view, seconds = TRAIL_S) {
  const [x, y] = [along(history, view.x), along(history, view.y)];
  if (!x || !y || !history.serial) return null;
  const { stride } = history, paired = stride > 1, out = [];
  let i = history.find(history.last - seconds / machine.period_s);
  const step = Math.max(1, Math.ceil((history.serial - i) / MOST));
  while (i < history.serial) {
    const first = paired && i + 1 < history.serial && Math.round(history.period(i) / stride) % 2 === 0;
    if (first) out.push([(x(i) + x(i + 1)) / 2, y(i)], [(x(i) + x(i + 1)) / 2, y(i + 1)]);
    else out.push([x(i), y(i)]);
    i += step * (first ? 2 : 1);
  }
  return out.filter(([a, b]) => Number.isFinite(a) && Number.isFinite(b));
}

/** How far from the surface the boundary layer's edge lies along each axis. */
function layerWidth({ surface, layer }) {
  if (!surface || layer?.length !== 2) return [0, 0];
  const up = Math.abs(layer[0][0][1] - surface[0][1]);
  const slope = Math.abs((surface[1][1] - surface[0][1]) / (surface[1][0] - surface[0][0]));
  return [slope > 0 ? up / slope : 0, up];
}

/** A line through two points, made so long that it crosses a box about zero. */
export function through([[x1, y1], [x2, y2]], halfX, halfY) {
  const [dx, dy] = [x2 - x1, y2 - y1];
  const reach = 4 * Math.max(Math.abs(dx) > 0 ? halfX / Math.abs(dx) : 0,
    Math.abs(dy) > 0 ? halfY / Math.abs(dy) : 0) + 4;
  return [[x1 - dx * reach, y1 - dy * reach], [x1 + dx * reach, y1 + dy * reach]];
}

function drawAxes(pen, data, box, x, y) {
  for (const tick of ticks(-data.halfX, data.halfX, Math.max(4, Math.floor(pen.width / 120)))) {
    pen.line([[x(tick), box.top], [x(tick), box.bottom]], tick === 0 ? "soft" : "faint");
    pen.text(tickText(tick), x(tick), box.bottom + 11, { align: "center", size: 12, colour: "soft" });
  }
  for (const tick of ticks(-data.halfY, data.halfY, 6)) {
    pen.line([[box.left, y(tick)], [box.right, y(tick)]], tick === 0 ? "soft" : "faint");
    pen.text(tickText(tick), box.left - 5, y(tick), { align: "right", size: 12, colour: "soft" });
  }
  pen.text(axis(data.view.x), box.right, box.bottom + 27, { align: "right" });
  pen.text(axis(data.view.y), box.left - 54, box.top - 18);
}

function axis(side) {
  return unit(side.unit) ? `${side.label} (${unit(side.unit)})` : side.label;
}

function drawPlane(pen, data) {
  const { view, trail, halfX, halfY } = data;
  const box = { left: 62, right: pen.width - 14, top: 30, bottom: pen.height - 38 };
  const x = scale(-halfX, halfX, box.left, box.right), y = scale(-halfY, halfY, box.bottom, box.top);
  const place = (points) => points.map(([a, b]) => [x(a), y(b)]);
  drawAxes(pen, data, box, x, y);
  pen.context.save();
  pen.context.beginPath();
  pen.context.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
  pen.context.clip();
  if (view.layer?.length === 2) {
    const [upper, lower] = view.layer.map((line) => place(through(line, halfX, halfY)));
    pen.area([...upper, ...lower.reverse()], "layer", 0.22);
    pen.line(upper, "layer", 1, [6, 4]);
    pen.line(lower, "layer", 1, [6, 4]);
  }
  if (view.surface) pen.line(place(through(view.surface, halfX, halfY)), "surface", 2);
  drawTrail(pen, place(trail));
  pen.dot(x(view.x.value), y(view.y.value), 6, "value");
  pen.context.restore();
}

function drawTrail(pen, points) {
  const parts = 4;
  for (let k = 0; k < parts; k++) {
    pen.context.globalAlpha = 0.25 + (0.75 * (k + 1)) / parts;
    const from = Math.floor((k * points.length) / parts), to = Math.floor(((k + 1) * points.length) / parts) + 1;
    pen.line(points.slice(from, to), "now", 1.5);
  }
  pen.context.globalAlpha = 1;
}

/** The view of the phase plane. */
export function phaseView(panel) {
  const picture = new Picture(drawPlane, 360, "Phase plane with sliding surface and boundary layer");
  const now = make("p", { class: "why-note" }), text = make("p", { class: "why-note" });
  let spans = [new Span(), new Span()], near = false;
  const kept = [];
  const closer = button("Near the trail", () => {
    near = !near;
    spans = [new Span(), new Span()];
    closer.setAttribute("aria-pressed", String(near));
  }, { "aria-pressed": "false", title: "Fit the picture to the trail instead of to the boundary layer" });
  return {
    name: "Phase plane",
    title: "Phase plane",
    read: READ,
    element: make("div", {}, picture.canvas, make("div", { class: "side-bar" }, now, closer), text),
    show(view) {
      if (view.x.value === null || view.y.value === null) return;
      kept.push([view.x.value, view.y.value]);
      if (kept.length > 10 * TRAIL_S) kept.shift();
      const trail = trailOf(panel, view) ?? kept, width = layerWidth(view);
      const [halfX, halfY] = spans.map((span, k) => {
        const most = trail.reduce((largest, p) => Math.max(largest, Math.abs(p[k])),
          Math.abs([view.x, view.y][k].value));
        return span.follow(near ? most : Math.max(most, 1.5 * width[k]));
      });
      picture.show({ view, trail, halfX, halfY });
      now.textContent = `Now: ${[view.x, view.y].map((a) => `${a.label} ${withUnit(a.value, a.unit, 3)}`).join(", ")}.`;
      text.textContent = view.text ?? "";
    },
  };
}
