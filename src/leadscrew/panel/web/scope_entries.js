/** The captures on the screen: the main one, those laid over it, and the signals that they hold. */

import { coloursOf } from "./format.js";
import { times } from "./measure.js";

const DASHES = [[8, 5], [2, 4], [12, 4, 2, 4], [5, 3, 5, 8]];

/** A capture with its columns side by side, a shift in seconds and how it is drawn. */
export class Entry {
  /** @param {object} capture as `panel.captures` holds it: `values` row-major, `columns`, `units`, `rows` */
  constructor(capture) {
    this.capture = capture;
    this.id = capture.id;
    this.name = capture.name;
    this.shift = 0;
    this.visible = true;
    this.dash = null; // of an overlay
    const names = capture.columns.map((c) => c.name ?? c);
    const wide = capture.values.length / Math.max(1, capture.rows);
    this.names = names.length > wide ? names.filter((n) => n !== "time") : names;
    this.columns = new Map();
  }

  unitOf(name) {
    const { units } = this.capture; // names of a log are anything, "constructor" too
    return units && Object.hasOwn(units, name) ? String(units[name] ?? "") : "";
  }

  /**
   * The values of a signal in its shown unit, or null where this capture has no such signal in a unit of it. A log of
   * another program may name its column as the plot does: then its numbers are taken in the unit that is shown.
   */
  values(signal) {
    const named = this.names.indexOf(signal.signal), at = named < 0 ? this.names.indexOf(signal.label) : named;
    if (at < 0) return null;
    const own = this.unitOf(this.names[at]), asShown = named < 0 && (!own || own === signal.unit);
    if (!asShown && own && signal.own && own !== signal.own) return null;
    const factor = asShown ? 1 : signal.factor, key = `${at} ${factor}`;
    if (!this.columns.has(key)) {
      const { values, rows } = this.capture, width = this.names.length, out = new Float64Array(rows);
      for (let i = 0; i < rows; i++) out[i] = values[i * width + at] * factor;
      this.columns.set(key, out);
    }
    return this.columns.get(key);
  }

  times() {
    return times(this.capture, this.shift);
  }
}

/** What is on the screen. */
export class Entries {
  constructor() {
    this.main = null;
    this.overlays = [];
  }

  get all() {
    return this.main ? [this.main, ...this.overlays] : this.overlays;
  }

  get shown() {
    return this.all.filter((e) => e.visible);
  }

  /** Takes a capture as the main one. */
  take(capture) {
    this.main = new Entry(capture);
  }

  /** Lays a capture over the main one, or makes it the main one where there is none; called by the name given. */
  lay(capture, name = capture.name) {
    if (!this.all.some((e) => e.id === capture.id)) {
      if (this.main) this.over(capture);
      else this.take(capture);
    }
    for (const entry of this.all) if (entry.id === capture.id) entry.name = name;
  }

  /** Draws the main capture dashed too, so that it stays when the next one takes its place. */
  keep() {
    if (this.main && !this.overlays.some((e) => e.id === this.main.id)) this.over(this.main.capture);
  }

  over(capture) {
    const entry = new Entry(capture), used = new Set(this.overlays.map((e) => e.dash));
    entry.dash = DASHES.find((d) => !used.has(d)) ?? DASHES[0];
    this.overlays.push(entry);
  }

  remove(entry) {
    if (entry === this.main) this.main = null;
    this.overlays = this.overlays.filter((e) => e !== entry);
  }

  /** From the first to the last time of all that is drawn, in seconds from the trigger. */
  extent() {
    let low = Infinity, high = -Infinity;
    for (const { capture, shift } of this.shown) {
      low = Math.min(low, -capture.trigger_row * capture.period_s + shift);
      high = Math.max(high, (capture.rows - 1 - capture.trigger_row) * capture.period_s + shift);
    }
    return high > low ? [low, high] : [Number.isFinite(low) ? low - 0.5 : 0, Number.isFinite(low) ? low + 0.5 : 1];
  }
}

/**
 * The signals that can be drawn: those of the machine's plots first, with their labels, factors and shown units, then
 * all other columns of the machine and of the captures.
 * @returns {{signal: string, label: string, factor: number, unit: string, own: string, role: string, first: boolean}[]}
 */
export function signalsOf(machine, entries) {
  const found = new Map();
  const units = new Map((machine?.columns ?? []).map((c) => [c.name, c.unit]));
  for (const plot of machine?.plots ?? []) {
    for (const trace of plot.traces) {
      if (found.has(trace.signal) || !units.has(trace.signal)) continue;
      const shown = { factor: trace.factor || 1, unit: trace.unit || plot.unit, own: units.get(trace.signal) };
      found.set(trace.signal, { ...trace, ...shown, first: true });
    }
  }
  const add = (name, unit) => {
    if (name === "time" || found.has(name)) return;
    found.set(name, { signal: name, label: name, factor: 1, unit, own: unit, role: "", first: false });
  };
  for (const [name, unit] of units) add(name, unit);
  for (const entry of entries) for (const name of entry.names) add(name, entry.unitOf(name));
  return [...found.values()];
}

const UNASKED = 4; // columns of an overlay that are shown at once where it has none of those shown

/**
 * The signals to be drawn so that something of an overlay is seen, and what is to be said of it.
 * @param {Entry} entry the overlay @param {object[]} drawn signals drawn now @param {object[]} all signals
 * @returns {{also: string[], words: string}} names to be drawn besides, and a sentence
 */
export function overlaid(entry, drawn, all) {
  const shared = drawn.filter((s) => entry.values(s));
  if (shared.length) {
    return { also: [], words: `${entry.name} is drawn dashed: ${shared.map((s) => s.label).join(", ")}.` };
  }
  const also = all.filter((s) => entry.values(s)).slice(0, UNASKED);
  if (!also.length) return { also: [], words: `${entry.name} has no column that can be drawn.` };
  const names = also.map((s) => s.label).join(", ");
  return { also: also.map((s) => s.signal),
    words: `${entry.name} has none of the signals shown; its ${names} ${also.length > 1 ? "are" : "is"} shown too.` };
}

/** Signals of one lane with a colour each. */
export function coloured(lane) {
  const colours = coloursOf(lane.signals);
  return lane.signals.map((s, i) => ({ ...s, colour: colours[i] }));
}
