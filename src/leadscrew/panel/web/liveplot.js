// One live plot: its legend with the values now, its tolerance bands, and the previous setting dashed below it.

import { Axis, usualLimit } from "./decimate.js";
import { button, make, put } from "./elements.js";
import { ROLES, coloursOf, faint, micro, number, steady, unit } from "./format.js";
import { drawBandAlong, drawLost, drawSignal } from "./lines.js";
import { toleranceAxis } from "./tolerance.js";

const FONT = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
const GRID = { stroke: "#d9dee3", width: 1 };
const GHOST = 0.6; // opacity of the previous setting
const NOTHING = [[0, 1], [null, null]]; // uPlot keeps the axes; the signals are drawn here

export class LivePlot {
  /**
   * @param {object} spec title, unit, traces, bands; `onRemove(signal)` where its traces can be taken away
   * @param {(signal: string) => number} slotOf number of a signal in the buckets
   * @param {boolean} last whether it has the time axis
   * @param {object} memory what outlives the plot: folded, hidden and fixed (sets of names), fold(title)
   */
  constructor(spec, slotOf, last, memory) {
    Object.assign(this, { spec, last, memory, folded: memory.folded.has(spec.title), told: "" });
    this.axis = new Axis();
    this.range = { low: 0, high: 1 };
    this.shown = { min: 0, max: 1 }; // the value axis as it is drawn
    const colours = coloursOf(spec.traces);
    this.traces = spec.traces.map((trace, i) => ({
      ...trace, factor: trace.factor ?? 1, colour: colours[i], slot: slotOf(trace.signal),
      shown: !memory.hidden.has(`${spec.title}/${trace.signal}`),
    }));
    this.bands = (spec.bands ?? []).map((band) => ({
      ...band, slot: band.about ? slotOf(band.about) : -1,
      factor: spec.traces.find((trace) => trace.signal === band.about)?.factor ?? spec.traces[0]?.factor ?? 1,
    })).filter((band) => !band.about || band.slot >= 0);
    this.place = make("div", { class: "canvas", hidden: this.folded });
    const label = `${spec.title}${spec.unit ? ` in ${unit(spec.unit)}` : ""}`;
    this.root = make("figure", { class: this.folded ? "plot folded" : "plot", "aria-label": label },
      this.head(), this.place);
  }

  head() {
    const { title, unit: of, onRemove } = this.spec;
    const shown = unit(of);
    const fold = button(shown ? `${title}, ${shown}` : title, () => this.memory.fold(title), {
      class: "title", title: "Click to fold or unfold this plot", "aria-expanded": String(!this.folded),
    });
    const whole = [...new Set(this.bands.map((band) => micro(band.doc || band.label)))].join("; ");
    this.note = button("", () => {
      this.root.classList.toggle("whole"); // all words of the tolerance, by a finger too
      this.memory.layout();
    }, { class: "note", title: whole, hidden: !this.bands.length });
    const entries = this.traces.flatMap((trace) => {
      const words = `Take ${trace.signal} away`;
      const away = onRemove
        && button("×", () => onRemove(trace.signal), { class: "away", title: words, "aria-label": words });
      return [this.entry(trace), away];
    });
    return make("figcaption", {}, fold, ...entries, this.bands.length > 0 && this.tolerance(), this.note);
  }

  /** A line of the legend: its colour, its name and its value; a click hides it. */
  entry(trace) {
    const mark = make("i", { class: trace.role === "command" ? "mark dotted" : "mark" });
    mark.style.borderColor = trace.colour;
    trace.value = make("b");
    const own = button("", () => {
      trace.shown = !trace.shown;
      this.remember("hidden", `${this.spec.title}/${trace.signal}`, !trace.shown);
      own.setAttribute("aria-pressed", String(trace.shown));
    }, {
      class: "entry", "aria-pressed": String(trace.shown),
      title: `${trace.signal}: ${ROLES[trace.role] || "signal"}. Click to hide or show it.`,
    });
    own.append(mark, `${trace.label} `, trace.value);
    return own;
  }

  /** The button that fixes the value axis about the bands, which a large move would make too narrow to be seen. */
  tolerance() {
    this.fixed = this.memory.fixed.has(this.spec.title);
    const own = button("Tolerance", () => {
      this.fixed = !this.fixed;
      this.remember("fixed", this.spec.title, this.fixed);
      own.setAttribute("aria-pressed", String(this.fixed));
    }, {
      class: "tolerance", "aria-label": "Show tolerance", "aria-pressed": String(this.fixed),
      title: "Fix the axis at three times the tolerance; again: the axis follows the lines",
    });
    return own;
  }

  remember(what, name, is) {
    this.memory[what][is ? "add" : "delete"](name);
    this.dirty = true;
  }

  size(width, height, sync) {
    if (this.plot) this.plot.setSize({ width, height });
    else this.plot = new uPlot(this.options(width, height, sync), NOTHING, this.place);
    this.dirty = true;
  }

  options(width, height, sync) {
    const axis = { font: FONT, stroke: "#1c2733", grid: GRID, ticks: { ...GRID, size: 4 }, labelFont: FONT };
    return {
      width, height, pxAlign: 0, padding: [8, 14, this.last ? 0 : 4, 0], legend: { show: false },
      cursor: { sync: { key: sync }, drag: { x: false, y: false }, points: { show: false }, y: false },
      scales: {
        x: { time: false, range: () => [this.from ?? 0, this.to ?? 1] },
        y: { range: () => [this.shown.min, this.shown.max] },
      },
      axes: [
        this.last
          ? { ...axis, size: 24, gap: 2, label: "time, s", labelSize: 16, labelGap: 0 }
          : { ...axis, size: 2, values: (u, splits) => splits.map(() => "") },
        { ...axis, size: 62, gap: 4, space: 17, values: (u, splits) => splits.map((value) => number(value, 6)) },
      ],
      series: [{}, { scale: "y", auto: false, paths: () => null, points: { show: false } }],
      hooks: { drawClear: [(u) => this.drawBands(u)], draw: [(u) => this.drawTraces(u)] },
    };
  }

  /** Draws what the buckets hold from `from` to `to` seconds. */
  draw(buckets, { from, to, now, periodS, ghost, dense, gaps, lost }) {
    if (this.folded || !this.plot) return;
    Object.assign(this, { buckets, from, to, periodS, ghost, dense, gaps, lost });
    const range = this.range;
    range.low = Infinity;
    range.high = -Infinity;
    for (const { shown, slot, factor } of this.traces) {
      if (!shown || slot < 0) continue;
      const limit = lost ? usualLimit(buckets, buckets.main[slot], from / periodS) : undefined;
      buckets.extent(buckets.main[slot], factor, from / periodS, range, limit);
      if (ghost) buckets.extent(buckets.old[slot], factor, from / periodS, range);
    }
    const { low, high } = range;
    this.fitBands(buckets, range, from / periodS);
    this.axis.fit(range.low, range.high, now);
    const fixed = this.fixed && toleranceAxis(this.bands, (band) => buckets.newest(band.slot) * band.factor);
    this.shown = fixed || this.axis;
    put(this.note, low < this.shown.min || high > this.shown.max ? `${this.told}; line beyond the axis` : this.told);
    this.dirty = false;
    this.plot.setScale("x", { min: from, max: to });
  }

  /** The range takes in the bands, unless they lie so far out that the signals would be a flat line between them. */
  fitBands(buckets, range, fromPeriod) {
    const { low, high } = range;
    const words = [];
    for (const band of this.bands) {
      const about = { low: 0, high: 0 };
      if (band.slot >= 0) {
        about.low = Infinity;
        about.high = -Infinity;
        buckets.extent(buckets.main[band.slot], band.factor, fromPeriod, about);
        if (about.low > about.high) continue;
      }
      const bottom = band.low + about.low;
      const top = band.high + about.high;
      const far = Math.max(top - Math.max(high, 0), Math.min(low, 0) - bottom);
      const outside = low <= high && band.slot < 0 && far > 6 * Math.max(high - low, Math.abs(high), Math.abs(low));
      if (!outside) {
        range.low = Math.min(range.low, bottom);
        range.high = Math.max(range.high, top);
      }
      const where = outside ? ` (${number(band.low)} to ${number(band.high)}, outside the picture)` : "";
      const text = micro(band.label) + (this.fixed ? "" : where);
      if (!words.includes(text)) words.push(text);
    }
    this.told = words.join("; ");
  }

  placeIn(u) {
    const { left, top, width, height } = u.bbox;
    const ky = -height / (this.shown.max - this.shown.min);
    const kx = (width / (this.to - this.from)) * this.periodS;
    return { x0: left - (this.from / this.periodS) * kx, kx, y0: top - this.shown.max * ky, ky };
  }

  clipped(u, draw) {
    if (!this.buckets) return;
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    draw(ctx, this.placeIn(u), bbox);
    ctx.restore();
  }

  drawTraces(u) {
    this.clipped(u, (ctx, place) => {
      const pixel = devicePixelRatio;
      for (const isGhost of this.ghost ? [true, false] : [false]) {
        for (const { shown, slot, factor, colour, role } of this.traces) {
          if (!shown || slot < 0) continue;
          const dash = role === "command" ? [2 * pixel, 3 * pixel] : isGhost ? [7 * pixel, 5 * pixel] : null;
          const pen = { colour: isGhost ? faint(colour, GHOST) : colour, width: (isGhost ? 1.5 : 2) * pixel, dash };
          const sides = isGhost ? this.buckets.old[slot] : this.buckets.main[slot];
          drawSignal(ctx, this.buckets, sides, factor, place, pen, this.dense, this.gaps);
        }
      }
      if (this.lost) drawLost(ctx, place.x0 + this.lost * place.kx, u.bbox, FONT);
    });
  }

  drawBands(u) {
    this.clipped(u, (ctx, place, bbox) => {
      for (const band of this.bands) {
        ctx.fillStyle = "rgba(0, 158, 115, 0.13)";
        ctx.strokeStyle = "rgba(0, 110, 80, 0.8)";
        ctx.lineWidth = devicePixelRatio;
        if (band.slot >= 0) {
          drawBandAlong(ctx, this.buckets, this.buckets.main[band.slot], band.factor, band.low, band.high, place);
          continue;
        }
        const top = place.y0 + band.high * place.ky;
        const height = (band.low - band.high) * place.ky;
        ctx.fillRect(bbox.left, top, bbox.width, height);
        ctx.strokeRect(bbox.left - 2, top, bbox.width + 4, height);
      }
    });
  }

  /** Values of the legend, from the newest row (or the row under the cursor while the display stands). */
  values(history, serial) {
    for (const trace of this.traces) {
      put(trace.value, serial < 0 ? "" : steady(history.value(trace.signal, serial) * trace.factor));
    }
  }

  destroy() {
    this.plot?.destroy();
    this.root.remove();
  }
}
