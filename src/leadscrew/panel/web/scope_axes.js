/** Axes and marks of the scope's lanes. */

import { make } from "./elements.js";
import { number, unit as written } from "./format.js";
import { coloured } from "./scope_entries.js";
import { lineKey } from "./scope_key.js";

/** Writes times of an axis that shows a range of seconds, in the unit that fits it. */
export function clock([low, high]) {
  const wide = high - low;
  const [part, of] = wide > 1.5 ? [1, "s"] : wide > 1.5e-3 ? [1e-3, "ms"] : [1e-6, "µs"];
  return (t) => `${number(Number((t / part).toPrecision(9)), 7)} ${of}`;
}

/** The trigger: an upright line at its time, and in the lane of its signal a line at its level. */
export function markTrigger(u, lane, trigger) {
  const { ctx, bbox } = u, dense = window.devicePixelRatio || 1;
  const line = (x1, y1, x2, y2) => { ctx.beginPath(); ctx.moveTo(x1, y1); ctx.lineTo(x2, y2); ctx.stroke(); };
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  Object.assign(ctx, { lineWidth: dense, strokeStyle: "#555", textAlign: "left", textBaseline: "alphabetic" });
  ctx.setLineDash([4 * dense, 3 * dense]);
  const x = u.valToPos(0, "x", true);
  line(x, bbox.top, x, bbox.top + bbox.height);
  const signal = trigger && lane.signals.find((s) => s.signal === trigger.signal);
  if (signal) {
    const y = u.valToPos(trigger.level * signal.factor, "y", true);
    line(bbox.left, y, bbox.left + bbox.width, y);
    ctx.fillStyle = "#333";
    ctx.font = `${12 * dense}px system-ui, sans-serif`;
    ctx.fillText("trigger", bbox.left + 4 * dense, y - 4 * dense);
  }
  ctx.restore();
}

/** Writes values of an axis with the decimals that its step has, so that two neighbours never read the same. */
export function stepped(step) {
  let places = 0;
  while (places < 8
    && Math.abs(step * 10 ** places - Math.round(step * 10 ** places)) > 1e-6 * step * 10 ** places) places++;
  return (v) => {
    if (v === null) return "";
    return places > 6 || Math.abs(v) >= 1e6 ? v.toExponential(3) : v.toFixed(places);
  };
}

/** The unit of a lane and its signals with their colours. */
export function caption(lane) {
  const keys = coloured(lane).map((s) => make("span", {}, lineKey(s.colour, null), s.label));
  return make("div", { class: "scope-caption" }, written(lane.unit) && make("b", {}, written(lane.unit)), ...keys);
}

/** A range of values with air above and below; also where all values are the same or there are none. */
export function spread(low, high) {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [-1, 1];
  const air = (high - low) * 0.06 || Math.abs(low) * 0.1 || 1;
  return [low - air, high + air];
}
