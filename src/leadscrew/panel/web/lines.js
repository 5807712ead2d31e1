// Signals drawn from buckets. Where a pixel holds many rows, the area from least to greatest value is filled: that is
// what a line through all of them would cover, at a small part of the work of stroking it.

/**
 * Where things lie on the canvas: x = x0 + period * kx, y = y0 + value * ky.
 * @typedef {{x0: number, kx: number, y0: number, ky: number}} Place
 */

/** Whether most buckets hold more than one row. */
export function isDense(buckets) {
  let many = 0;
  for (let n = buckets.oldest; n < buckets.made; n += 1) {
    const at = n % buckets.count;
    if (buckets.lasts[at] > buckets.firsts[at]) many += 1;
  }
  return many > (buckets.made - buckets.oldest) / 2;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("./decimate.js").Buckets} buckets
 * @param {Sides} sides least and greatest values of the signal: buckets.main[slot] or buckets.old[slot]
 * @param {Place} place for values times factor
 * @param {object} pen colour, width in pixels, dash [on, off] in pixels or null
 * @param {number[][]} gaps periods between which rows are missing
 */
export function drawSignal(ctx, buckets, sides, factor, place, pen, dense, gaps) {
  const scaled = { ...place, ky: place.ky * factor };
  if (dense) fillEnvelope(ctx, buckets, sides, scaled, pen, gaps);
  else strokePoints(ctx, buckets, sides, scaled, pen, gaps);
}

const FAR = 1e5; // pixels: a canvas loses a line whose end lies farther out

function near(y) { return Math.max(-FAR, Math.min(FAR, y)); }

/** The period in which the machine was lost: a line from top to bottom. */
export function drawLost(ctx, x, { top, height }, font) {
  ctx.strokeStyle = ctx.fillStyle = "#a33c00";
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x - ctx.lineWidth, top);
  ctx.lineTo(x - ctx.lineWidth, top + height);
  ctx.stroke();
  ctx.font = font.replace("12px", `${12 * devicePixelRatio}px`);
  ctx.textAlign = "right";
  ctx.fillText("lost", x - 6 * devicePixelRatio, top + 14 * devicePixelRatio);
}

function isAfterGap(gaps, before, period) {
  for (const [start, end] of gaps) if (before <= start && period >= end) return true;
  return false;
}

function strokePoints(ctx, buckets, { low, high, rising }, place, pen, gaps) {
  const { firsts, lasts, count } = buckets;
  const { x0, kx, y0, ky } = place;
  ctx.strokeStyle = pen.colour;
  ctx.lineWidth = pen.width;
  ctx.lineJoin = "bevel";
  ctx.setLineDash(pen.dash ?? []);
  ctx.lineDashOffset = 0;
  ctx.beginPath();
  let before = -1;
  for (let n = buckets.oldest; n < buckets.made; n += 1) {
    const at = n % count;
    const value = rising[at] ? low[at] : high[at];
    if (value !== value) { before = -1; continue; }
    const x = x0 + firsts[at] * kx;
    if (before < 0 || (gaps.length && isAfterGap(gaps, before, firsts[at]))) ctx.moveTo(x, near(y0 + value * ky));
    else ctx.lineTo(x, near(y0 + value * ky));
    if (lasts[at] > firsts[at]) ctx.lineTo(x0 + lasts[at] * kx, near(y0 + (rising[at] ? high[at] : low[at]) * ky));
    before = lasts[at];
  }
  ctx.stroke();
  ctx.setLineDash([]);
}

function fillEnvelope(ctx, buckets, sides, place, pen, gaps) {
  const { ids, firsts, lasts, count, width } = buckets;
  const pixels = width * Math.abs(place.kx); // of a bucket
  const on = pen.dash ? Math.max(1, Math.round(pen.dash[0] / pixels)) : 0;
  const cycle = pen.dash ? on + Math.max(1, Math.round(pen.dash[1] / pixels)) : 1;
  ctx.fillStyle = pen.colour;
  ctx.beginPath();
  let start = -1;
  for (let n = buckets.oldest; n < buckets.made; n += 1) {
    const at = n % count;
    const shown = sides.low[at] === sides.low[at] && (!on || ids[at] % cycle < on);
    const breaks = start >= 0 && (ids[at] - ids[(n - 1) % count] > 1)
      && (gaps.length ? isAfterGap(gaps, lasts[(n - 1) % count], firsts[at]) : Boolean(on));
    if (start >= 0 && (!shown || breaks)) {
      outline(ctx, buckets, sides, place, pen.width, start, n);
      start = -1;
    }
    if (shown && start < 0) start = n;
  }
  if (start >= 0) outline(ctx, buckets, sides, place, pen.width, start, buckets.made);
  ctx.fill();
}

/** The outline of the buckets from `start` to before `end`, as wide as the line at least. */
function outline(ctx, buckets, { low, high }, { x0, kx, y0, ky }, thick, start, end) {
  const { ids, count, width } = buckets;
  const upper = ky < 0 ? high : low; // pixels count downwards
  const lower = ky < 0 ? low : high;
  const half = thick / 2;
  const left = x0 + ids[start % count] * width * kx;
  const right = x0 + (ids[(end - 1) % count] + 1) * width * kx;
  ctx.moveTo(left, near(y0 + upper[start % count] * ky) - half);
  for (let n = start; n < end; n += 1) {
    const at = n % count;
    ctx.lineTo(x0 + (ids[at] + 0.5) * width * kx, near(y0 + upper[at] * ky) - half);
  }
  ctx.lineTo(right, near(y0 + upper[(end - 1) % count] * ky) - half);
  ctx.lineTo(right, near(y0 + lower[(end - 1) % count] * ky) + half);
  for (let n = end - 1; n >= start; n -= 1) {
    const at = n % count;
    ctx.lineTo(x0 + (ids[at] + 0.5) * width * kx, near(y0 + lower[at] * ky) + half);
  }
  ctx.lineTo(left, near(y0 + lower[start % count] * ky) + half);
  ctx.closePath();
}

/** A band that follows a signal: from `below` under its middle to `above` over it, in the unit of the place. */
export function drawBandAlong(ctx, buckets, { low, high }, factor, below, above, { x0, kx, y0, ky }) {
  const { firsts, lasts, count } = buckets;
  ctx.beginPath();
  const there = [above, buckets.oldest, buckets.made, 1];
  const back = [below, buckets.made - 1, buckets.oldest - 1, -1];
  for (const [offset, from, to, by] of [there, back]) {
    for (let n = from; n !== to; n += by) {
      const at = n % count;
      ctx.lineTo(x0 + ((firsts[at] + lasts[at]) / 2) * kx, y0 + (((low[at] + high[at]) / 2) * factor + offset) * ky);
    }
  }
  ctx.closePath();
  ctx.fill();
  ctx.stroke();
}
