// What acceptance asks of the page, measured in the page: frames a second, and change to visible.

const KEPT = 200;

/** Times from sending a change to the first frame drawn that holds a period at or after it. */
export class Latency {
  constructor(panel) {
    this.panel = panel;
    this.pending = [];
  }

  static counts(what) { return what === "set" || what === "undo" || what === "redo" || what === "disturb"; }

  expect(sent, period) { this.pending.push({ sent, period }); }

  clear() { this.pending.length = 0; }

  /** To be called when a frame was drawn whose newest row is of the period `last`. */
  drawn(last) {
    for (let i = this.pending.length - 1; i >= 0; i -= 1) {
      if (last < this.pending[i].period) continue;
      const times = this.panel.measures.latency_ms;
      times.push(performance.now() - this.pending[i].sent);
      if (times.length > KEPT) times.shift();
      this.pending.splice(i, 1);
    }
  }
}

/** Frames drawn in the last second. */
export class Frames {
  constructor() {
    this.times = new Float64Array(256);
    this.count = 0;
  }

  drawn(now) {
    this.times[this.count & 255] = now;
    this.count += 1;
  }

  perSecond(now) {
    const end = Math.max(0, this.count - 256);
    let first = this.count;
    while (first > end && now - this.times[(first - 1) & 255] <= 1000) first -= 1;
    return this.count - first;
  }
}
