// The rows of the histories in as many buckets as the plot has pixels: least and greatest value of each, kept up to
// date row by row, so that a frame of the screen costs the same however many rows came.

/** Buckets are numbered from period 0 on: bucket k holds the periods from k * width to (k + 1) * width. */
export class Buckets {
  /**
   * @param {import("./history.js").History} history
   * @param {import("./history.js").History} ghost the same columns under the previous setting
   * @param {number[]} columns numbers of the columns shown
   * @param {number} width periods a bucket
   * @param {number} count buckets held
   * @param {number} ghostFrom period of the change: rows of the ghost before it belong to an older setting
   */
  constructor(history, ghost, columns, width, count, ghostFrom = 0) {
    Object.assign(this, { history, ghost, columns, width, count, ghostFrom });
    this.ids = new Float64Array(count);
    this.firsts = new Float64Array(count); // period of the first row of the bucket, and of the last
    this.lasts = new Float64Array(count);
    this.main = columns.map(() => new Sides(count));
    this.old = columns.map(() => new Sides(count));
    this.restart();
  }

  /** Fills all buckets from what the histories hold. */
  restart() {
    this.made = 0; // buckets made so far; bucket number n lies at n % count
    const from = this.history.last - this.width * this.count;
    this.done = this.history.find(from);
    this.restartGhost();
    this.update();
  }

  restartGhost(ghostFrom = this.ghostFrom) {
    this.ghostFrom = ghostFrom;
    for (const sides of this.old) sides.clear();
    const start = this.made ? this.firsts[this.oldest % this.count] : 0;
    this.ghostDone = this.ghost.find(Math.max(start, this.ghostFrom));
    this.ghostBucket = this.oldest;
  }

  get oldest() { return Math.max(0, this.made - this.count); }

  update() {
    const { history, width, count, main, columns } = this;
    if (history.serial < this.done) this.done = 0; // cleared
    if (this.done < history.oldest) this.done = history.oldest;
    for (; this.done < history.serial; this.done += 1) {
      const period = history.period(this.done);
      const id = Math.floor(period / width);
      let at = (this.made - 1) % count;
      if (this.made === 0 || this.ids[at] !== id) {
        at = this.made % count;
        this.made += 1;
        this.ids[at] = id;
        this.firsts[at] = period;
        for (let i = 0; i < columns.length; i += 1) {
          main[i].begin(at, history.data[columns[i]][this.done & history.mask]);
          this.old[i].begin(at, NaN);
        }
      } else {
        for (let i = 0; i < columns.length; i += 1) main[i].add(at, history.data[columns[i]][this.done & history.mask]);
      }
      this.lasts[at] = period;
    }
    this.updateGhost();
  }

  updateGhost() {
    const { ghost, width, count, old, columns } = this;
    if (ghost.serial < this.ghostDone) this.ghostDone = 0;
    if (this.ghostDone < ghost.oldest) this.ghostDone = ghost.oldest;
    if (this.ghostBucket < this.oldest) this.ghostBucket = this.oldest;
    for (; this.ghostDone < ghost.serial; this.ghostDone += 1) {
      const id = Math.floor(ghost.period(this.ghostDone) / width);
      while (this.ghostBucket < this.made && this.ids[this.ghostBucket % count] < id) this.ghostBucket += 1;
      if (this.ghostBucket >= this.made) return; // the machine's own rows of that time are still to come
      const at = this.ghostBucket % count;
      if (this.ids[at] !== id) continue;
      for (let i = 0; i < columns.length; i += 1) old[i].add(at, ghost.data[columns[i]][this.ghostDone & ghost.mask]);
    }
  }

  /** Middle of the newest bucket of a signal; NaN where there is none. */
  newest(slot) {
    if (!this.made) return NaN;
    const at = (this.made - 1) % this.count;
    return (this.main[slot].low[at] + this.main[slot].high[at]) / 2;
  }

  /** Widens `range` by what a signal (its sides) shows from a period on, times a factor; not by values beyond `limit`. */
  extent({ low, high }, factor, fromPeriod, range, limit = Number.MAX_VALUE) {
    let least = Infinity;
    let most = -Infinity;
    for (let n = this.made - 1; n >= this.oldest; n -= 1) {
      const at = n % this.count;
      if (this.lasts[at] < fromPeriod) break;
      if (low[at] < least && low[at] >= -limit) least = low[at];
      if (high[at] > most && high[at] <= limit) most = high[at];
    }
    if (least > most) return;
    range.low = Math.min(range.low, least * factor, most * factor);
    range.high = Math.max(range.high, least * factor, most * factor);
  }
}

const BEYOND = 100; // times what a signal reached before it ran away

/** The size up to which a signal that ran away is worth a scale: far beyond its usual one, but not that of its end. */
export function usualLimit(buckets, { low, high }, fromPeriod) {
  const sizes = [];
  for (let n = buckets.oldest; n < buckets.made; n += 1) {
    const at = n % buckets.count;
    const size = Math.max(Math.abs(low[at]), Math.abs(high[at]));
    if (buckets.lasts[at] >= fromPeriod && Number.isFinite(size)) sizes.push(size);
  }
  sizes.sort((a, b) => a - b);
  const usual = sizes[Math.floor(0.75 * (sizes.length - 1))];
  return usual > 0 ? BEYOND * usual : Number.MAX_VALUE;
}

/** Least and greatest value of each bucket, and which of them came first. */
class Sides {
  constructor(count) {
    this.low = new Float32Array(count).fill(NaN);
    this.high = new Float32Array(count).fill(NaN);
    this.rising = new Uint8Array(count);
  }

  clear() {
    this.low.fill(NaN);
    this.high.fill(NaN);
  }

  begin(at, value) {
    this.low[at] = value;
    this.high[at] = value;
    this.rising[at] = 1;
  }

  add(at, value) {
    if (!(this.low[at] <= value) && value === value) {
      if (this.low[at] !== this.low[at]) this.high[at] = value;
      this.low[at] = value;
      this.rising[at] = 0;
    } else if (value > this.high[at]) {
      this.high[at] = value;
      this.rising[at] = 1;
    }
  }
}

/**
 * The range of an axis that shows [low, high]: opened at once, closed again only when the values have needed much less
 * for a while, and always between round numbers, so that it does not jitter.
 */
export class Axis {
  constructor() { this.min = NaN; }

  fit(low, high, now) {
    if (!(low <= high)) { low = this.min === this.min ? this.min : -1; high = this.min === this.min ? this.max : 1; }
    let span = high - low;
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (!(span > size * 1e-5)) {
      span = size > 0 ? size * 0.2 : 2;
      low -= span / 2;
      high += span / 2;
    }
    const step = 10 ** Math.floor(Math.log10(span / 2));
    const part = span / 2 / step;
    const nice = step * (part >= 5 ? 5 : part >= 2 ? 2 : 1) / 2;
    const min = Math.floor((low - span * 0.04) / nice) * nice;
    const max = Math.ceil((high + span * 0.04) / nice) * nice;
    if (!(this.min <= low && high <= this.max)) {
      this.min = Math.min(min, this.min <= low ? this.min : min);
      this.max = Math.max(max, this.max >= high ? this.max : max);
      this.since = now;
      this.closing = false;
    } else if (max - min > 0.7 * (this.max - this.min)) {
      this.since = now;
      this.closing = false;
    } else if (now - this.since > 800) {
      this.min = min;
      this.max = max;
      this.closing = false;
    } else {
      this.closing = true; // to be asked again, though no row came
    }
    return this;
  }
}
