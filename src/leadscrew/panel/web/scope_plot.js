/** Captured signals against the time from the trigger: one lane for each unit, all on the same time axis. */

import { fill, make } from "./elements.js";
import { unit as written } from "./format.js";
import { lanes, panned, zoomed } from "./measure.js";
import { caption, clock, markTrigger, spread, stepped } from "./scope_axes.js";
import { coloured } from "./scope_entries.js";

/* global uPlot */
const LEFT = 76; // width of every value axis, so that the lanes stand under each other
const RIGHT = 28; // room for half a time
const AXIS = 26; // height of the time axis below the last lane
const LEAST = 100; // height of a lane

export class ScopePlot {
  /**
   * @param {HTMLElement} element where the lanes go
   * @param {(range: [number, number]) => void} onRange told whenever another stretch of time is shown
   */
  constructor(element, onRange) {
    this.element = element;
    this.onRange = onRange;
    this.plots = [];
    this.key = "";
    this.range = [0, 1];
    this.limits = [0, 1];
    this.least = 0; // seconds of the shortest stretch that zoom shows
    this.trigger = null;
    element.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    element.addEventListener("keydown", (event) => this.keyed(event));
    new ResizeObserver(() => this.resize()).observe(element);
  }

  /** Draws the signals of the entries; keeps the stretch shown where the whole is the same as before. */
  show(entries, signals, trigger) {
    this.trigger = trigger;
    const limits = entries.extent(), same = limits.every((x, i) => Math.abs(x - this.limits[i]) < 1e-9);
    this.limits = limits;
    this.least = 5 * Math.min(...entries.shown.map((e) => e.capture.period_s), limits[1] - limits[0]);
    const present = signals.filter((s) => entries.shown.some((e) => e.values(s)));
    this.groups = lanes(present);
    const key = JSON.stringify([this.groups, entries.shown.map((e) => [e.id === entries.main?.id, e.name, e.dash])]);
    const data = this.groups.map((lane) => this.dataOf(lane, entries));
    if (key !== this.key) {
      this.key = key;
      this.build(entries);
    }
    if (!same) this.range = [...limits];
    this.plots.forEach((plot, i) => plot.setData(data[i], false));
    this.setRange(this.range);
  }

  /** One table of times and values for a lane; captures of other times are joined. */
  dataOf(lane, entries) {
    const tables = entries.shown.map((e) => {
      const held = lane.signals.map((s) => e.values(s) ?? new Float64Array(e.capture.rows).fill(NaN));
      return [e.times(),
        ...held.map((v) => (v.some(Number.isNaN) ? Array.from(v, (x) => (Number.isNaN(x) ? null : x)) : v))];
    });
    return tables.length === 1 ? tables[0] : uPlot.join(tables);
  }

  build(entries) {
    for (const plot of this.plots) plot.destroy();
    fill(this.element);
    const lanesHigh = Math.min(4, this.groups.length) * LEAST;
    this.element.parentElement.style.minHeight = this.groups.length ? `${lanesHigh + AXIS + 18}px` : "";
    this.plots = this.groups.map((lane, at) => {
      const place = make("div", { class: "scope-lane" }, caption(lane));
      this.element.append(place);
      return new uPlot(this.options(lane, at, entries), [[0]], place);
    });
    this.resize();
  }

  options(lane, at, entries) {
    const signals = coloured(lane), last = at === this.groups.length - 1;
    const series = entries.shown.flatMap((e) => signals.map((s) => ({
      label: e === entries.main ? s.label : `${s.label}, ${e.name}`,
      stroke: s.colour, width: e === entries.main ? 1.6 : 1.4, dash: e.dash ?? undefined, points: { show: false },
    })));
    const grid = { stroke: "rgba(0,0,0,0.12)", width: 1 },
      style = { stroke: "#333", grid, ticks: grid, font: "12px system-ui, sans-serif" };
    return {
      width: 400, height: LEAST, legend: { show: false }, padding: [19, RIGHT, last ? 0 : 3, 0],
      scales: { x: { time: false, range: () => this.range }, y: { range: (u, low, high) => spread(low, high) } },
      series: [{}, ...series],
      axes: [
        { ...style, side: 2, size: last ? 30 : 6, values: last ? (u, all) => all.map(clock(this.range)) : () => [],
          ticks: { ...grid, size: last ? 5 : 0 } },
        { ...style, size: LEFT, space: 19, values: (u, all, axis, space, step) => all.map(stepped(step)) },
      ],
      cursor: {
        y: false, points: { show: false }, drag: { x: true, y: false, setScale: false },
          sync: { key: "leadscrew-scope" },
        bind: { mousedown: (u, t, go) => (e) => this.pressed(u, e, go), dblclick: () => () => this.all() },
      },
      hooks: {
        setSelect: [(u) => this.selected(u)],
        draw: [(u) => markTrigger(u, lane, this.trigger)],
      },
    };
  }

  selected(u) {
    const { left, width } = u.select;
    if (width < 4) return;
    const range = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
    u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.setRange(zoomed(range, range[0], 1, this.limits, this.least));
  }

  /** The mouse on a lane: drags a stretch to zoom, or with Shift or the middle button moves along. */
  pressed(u, event, go) {
    if (event.button === 0 && !event.shiftKey) return go(event);
    if (event.button === 2) return null;
    const from = event.clientX, range = [...this.range], wide = u.over.clientWidth || 1;
    const move = (e) => this.setRange(panned(range, (-(e.clientX - from) / wide) * (range[1] - range[0]), this.limits));
    const end = () => { removeEventListener("pointermove", move); removeEventListener("pointerup", end); };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
    return null;
  }

  wheel(event) {
    const over = event.target.closest?.(".u-over");
    if (!over || !this.plots.length) return;
    event.preventDefault();
    const box = over.getBoundingClientRect(), share = (event.clientX - box.left) / box.width;
    const about = this.range[0] + share * (this.range[1] - this.range[0]);
    if (event.shiftKey) this.move(Math.sign(event.deltaY || event.deltaX) * 0.1);
    else this.zoom(event.deltaY > 0 ? 1.25 : 0.8, about);
  }

  keyed(event) {
    if (event.target !== this.element || event.ctrlKey || event.altKey || event.metaKey) return;
    const acts = {
      "+": () => this.zoom(0.5), "=": () => this.zoom(0.5), "-": () => this.zoom(2), 0: () => this.all(),
      ArrowLeft: () => this.move(-0.1), ArrowRight: () => this.move(0.1), Home: () => this.move(-1e9),
        End: () => this.move(1e9),
    };
    if (!acts[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    acts[event.key]();
  }

  zoom(factor, about = (this.range[0] + this.range[1]) / 2) {
    this.setRange(zoomed(this.range, about, factor, this.limits, this.least));
  }

  /** Moves along by a share of what is shown. */
  move(share) {
    this.setRange(panned(this.range, share * (this.range[1] - this.range[0]), this.limits));
  }

  all() {
    this.setRange([...this.limits]);
  }

  setRange(range) {
    this.range = range;
    for (const plot of this.plots) plot.setScale("x", { min: range[0], max: range[1] });
    this.onRange(range);
  }

  /** Shares the height of the view between the lanes. */
  resize() {
    const width = this.element.clientWidth, height = this.element.clientHeight;
    if (!width || !this.plots.length) return;
    const each = Math.max(LEAST, Math.floor((height - AXIS) / this.plots.length));
    this.plots.forEach((plot, i) => plot.setSize({ width, height: each + (i === this.plots.length - 1 ? AXIS : 0) }));
    this.onRange(this.range);
  }

  /** Pixels from the left of the element at a time, or NaN where it is not shown. */
  pixelOf(time) {
    const wide = this.element.clientWidth - LEFT - RIGHT,
      share = (time - this.range[0]) / (this.range[1] - this.range[0]);
    return share >= -1e-9 && share <= 1 + 1e-9 ? LEFT + share * wide : NaN;
  }

  /** The time at pixels from the left of the element. */
  timeAt(pixel) {
    const wide = this.element.clientWidth - LEFT - RIGHT;
    return this.range[0] + ((pixel - LEFT) / wide) * (this.range[1] - this.range[0]);
  }

  /** Words for each lane, for the legend. */
  legend(entries) {
    return (this.groups ?? []).map((lane) => ({ unit: written(lane.unit), signals: coloured(lane),
      entries: entries.shown }));
  }
}
