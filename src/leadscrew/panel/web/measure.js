/**
 * Measuring a capture: which row a time is, figures between two cursors, groups of signals of one unit.
 *
 * Nothing here touches the page, so that it can be tested alone.
 */

/**
 * The row nearest to a time.
 * @param {{rows: number, period_s: number, trigger_row: number}} capture
 * @param {number} time seconds from the trigger
 * @returns {number} a row, kept inside the capture
 */
export function rowAt(capture, time) {
  const row = Math.round(time / capture.period_s) + capture.trigger_row;
  return Math.min(capture.rows - 1, Math.max(0, row));
}

/** @returns {number} seconds from the trigger of a row */
export function timeOf(capture, row) {
  return (row - capture.trigger_row) * capture.period_s;
}

/** @returns {Float64Array} seconds from the trigger of every row, moved by a shift in seconds */
export function times(capture, shift = 0) {
  const out = new Float64Array(capture.rows);
  for (let i = 0; i < out.length; i++) out[i] = timeOf(capture, i) + shift;
  return out;
}

/**
 * Figures of a stretch, both ends included; values that are not finite are left out.
 * @param {ArrayLike<number>} values
 * @param {number} from a row
 * @param {number} to a row, before or after `from`
 * @returns {{count: number, min: number, max: number, mean: number, rms: number}} NaN where nothing is finite
 */
export function statistics(values, from, to) {
  const first = Math.max(0, Math.min(from, to));
  const last = Math.min(values.length - 1, Math.max(from, to));
  let count = 0, min = Infinity, max = -Infinity, sum = 0, squares = 0;
  for (let i = first; i <= last; i++) {
    const v = values[i];
    if (!Number.isFinite(v)) continue;
    count++;
    if (v < min) min = v;
    if (v > max) max = v;
    sum += v;
    squares += v * v;
  }
  if (count === 0) return { count, min: NaN, max: NaN, mean: NaN, rms: NaN };
  return { count, min, max, mean: sum / count, rms: Math.sqrt(squares / count) };
}

/**
 * What two cursors read of one signal.
 * @param {object} capture with `rows`, `period_s`, `trigger_row`
 * @param {ArrayLike<number>} values the signal's values, one for each row
 * @param {number} a seconds from the trigger (of this capture, shift already taken off)
 * @param {number} b likewise
 */
export function reading(capture, values, a, b) {
  const i = rowAt(capture, a), j = rowAt(capture, b);
  return { a: values[i], b: values[j], difference: values[j] - values[i], ...statistics(values, i, j) };
}

/**
 * Signals in lanes, one lane for each unit, in the order in which the units come up.
 * @param {{unit: string}[]} signals
 * @returns {{unit: string, signals: object[]}[]}
 */
export function lanes(signals) {
  const found = new Map();
  for (const s of signals) {
    if (!found.has(s.unit)) found.set(s.unit, { unit: s.unit, signals: [] });
    found.get(s.unit).signals.push(s);
  }
  return [...found.values()];
}

/** A range zoomed by a factor about a place (factor < 1 shows less), kept inside the limits. */
export function zoomed(range, about, factor, limits, least = 0) {
  const width = Math.max(least, Math.min(limits[1] - limits[0], (range[1] - range[0]) * factor));
  const share = (about - range[0]) / (range[1] - range[0] || 1);
  return panned([about - share * width, about + (1 - share) * width], 0, limits);
}

/** A range moved by a distance, kept inside the limits with its width. */
export function panned(range, by, limits) {
  const width = Math.min(range[1] - range[0], limits[1] - limits[0]);
  const low = Math.min(Math.max(range[0] + by, limits[0]), limits[1] - width);
  return [low, low + width];
}
