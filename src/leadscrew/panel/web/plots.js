// The live view: a plot for every plot of the profile, stacked over one moving time axis.

import { Buckets } from "./decimate.js";
import { unit } from "./format.js";
import { isDense } from "./lines.js";
import { LivePlot } from "./liveplot.js";
import { mountReadouts } from "./readouts.js";
import { Frames } from "./timing.js";

const WINDOWS_S = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60];
const LEAST_HEIGHT = 72; // pixels of a plot without its heading
const HEAD = 25; // pixels of a heading
const TIME_AXIS = 40; // pixels that the last plot needs more
const LEGEND_MS = 200;

export function mountPlots(element, panel) {
  const view = new LiveView(element, panel);
  panel.live = view;
  return view;
}

class LiveView {
  constructor(element, panel) {
    this.panel = panel;
    this.plots = [];
    this.extra = []; // names of further signals
    this.paused = false;
    this.frames = new Frames();
    this.memory = { folded: new Set(), hidden: new Set(), fixed: new Set(), fold: (title) => this.fold(title),
      layout: () => { this.width = 0; this.layout(); } };
    element.innerHTML = `<div class="tools">
      <label>Window <select id="window"></select></label>
      <button type="button" id="pause" aria-pressed="false" aria-keyshortcuts="P"
        title="The display stands still; the machine runs on">Pause <kbd>P</kbd></button>
      <select id="further" aria-label="Add a further signal to the plots"></select>
      <span id="rate" aria-hidden="true"></span></div>
      <div class="readouts" role="group" aria-label="Process values" hidden></div>
      <div class="stack"><p class="empty">Waiting for the machine.</p></div>`;
    this.stack = element.querySelector(".stack");
    mountReadouts(element.querySelector(".readouts"), panel);
    this.choose = element.querySelector("#window");
    this.further = element.querySelector("#further");
    this.button = element.querySelector("#pause");
    this.rate = element.querySelector("#rate");
    this.choose.addEventListener("change", () => { this.window = Number(this.choose.value); this.rebucket(); });
    this.further.addEventListener("change", () => this.add(this.further.value));
    this.button.addEventListener("click", () => this.pause(!this.paused));
    new ResizeObserver(() => this.layout()).observe(this.stack);
    panel.on("machine", () => this.renew());
    panel.on("fresh", () => this.rebucket());
    panel.on("rows", () => { this.moved = true; });
    panel.on("state", (state) => this.onState(state));
    this.step = this.step.bind(this);
    requestAnimationFrame(this.step);
  }

  /** New plots where the machine shows other things; new rings where it is another run. */
  renew() {
    const { machine, history } = this.panel;
    const offered = `${machine.study}/${machine.run}`;
    if (offered !== this.offered) {
      if (this.study !== machine.study) {
        this.window = machine.window_s;
        this.extra = [];
        if (this.study) this.memory.fixed.clear(); // another machine, other tolerances
        this.study = machine.study;
        this.foldRest(machine.plots);
      }
      this.offered = offered;
      this.pause(false);
    }
    this.extra = this.extra.filter((name) => history.names.includes(name));
    this.windows(machine);
    this.signals(machine);
    this.build();
  }

  windows(machine) {
    const least = 10 * machine.period_s;
    const most = 60000 * machine.period_s * Math.max(1, 0.0005 / machine.period_s);
    const fits = (s) => s === machine.window_s || (s >= least && s <= most);
    const lengths = [...new Set([...WINDOWS_S, machine.window_s])].filter(fits);
    lengths.sort((a, b) => a - b);
    this.choose.replaceChildren(...lengths.map((s) => new Option(s < 1 ? `${Math.round(s * 1000)} ms` : `${s} s`, s)));
    this.choose.value = String(this.window);
  }

  signals(machine) {
    const plotted = machine.plots.flatMap((plot) => plot.traces.map((trace) => trace.signal));
    const shown = new Set([...plotted, ...this.extra]);
    const free = machine.columns.filter((column) => column.name !== "time" && !shown.has(column.name));
    const words = (column) => (unit(column.unit) ? `${column.name}, ${unit(column.unit)}` : column.name);
    this.further.replaceChildren(new Option("Add signal ...", ""),
      ...free.map((column) => new Option(words(column), column.name)));
  }

  add(name) {
    if (!name || this.extra.includes(name)) return;
    this.extra.push(name);
    this.signals(this.panel.machine);
    this.build();
  }

  remove(name) {
    this.extra = this.extra.filter((other) => other !== name);
    this.signals(this.panel.machine);
    this.build();
  }

  /** Further signals: a plot for every unit. */
  extras() {
    const units = new Map();
    for (const name of this.extra) {
      const of = this.panel.machine.columns.find((column) => column.name === name)?.unit ?? "";
      if (!units.has(of)) units.set(of, []);
      units.get(of).push({ signal: name, label: name, role: "other", factor: 1, unit: of });
    }
    return [...units].map(([of, traces]) => ({
      title: "Further", unit: of, traces, bands: [], onRemove: (signal) => this.remove(signal),
    }));
  }

  /** At first the last plots are folded where all of them would not fit; their values are still in their headings. */
  foldRest(plots) {
    const height = this.stack.clientHeight - TIME_AXIS - 2 - HEAD * plots.length;
    const fit = Math.max(2, Math.floor(height / LEAST_HEIGHT));
    this.memory.folded = new Set(plots.slice(fit).map((plot) => plot.title));
    this.memory.hidden.clear();
  }

  fold(title) {
    this.memory.folded[this.memory.folded.has(title) ? "delete" : "add"](title);
    this.build();
  }

  build() {
    for (const plot of this.plots) plot.destroy();
    const { machine, history } = this.panel;
    const known = (signal) => history.names.includes(signal);
    const specs = [...machine.plots, ...this.extras()]
      .map((plot) => ({ ...plot, traces: plot.traces.filter((trace) => known(trace.signal)) }))
      .filter((plot) => plot.traces.length);
    const slots = new Map();
    const slotOf = (signal) => {
      if (!known(signal)) return -1;
      if (!slots.has(signal)) slots.set(signal, slots.size);
      return slots.get(signal);
    };
    const open = specs.filter((spec) => !this.memory.folded.has(spec.title));
    this.plots = specs.map((spec) => new LivePlot(spec, slotOf, spec === open.at(-1), this.memory));
    this.slots = [...slots.keys()];
    this.stack.replaceChildren(...this.plots.map((plot) => plot.root));
    if (!this.plots.length) this.stack.textContent = "This machine names no plots; choose a further signal.";
    this.width = 0;
    this.layout();
  }

  /** Shares the height among the plots that are not folded; where it is too little, the stack scrolls. */
  layout() {
    const width = this.stack.clientWidth;
    const height = this.stack.clientHeight;
    if (!width || !height || !this.plots.length) return;
    if (width === this.width && height === this.height) return;
    this.width = width;
    this.height = height;
    const open = this.plots.filter((plot) => !plot.folded);
    const heads = this.plots.reduce((sum, plot) => sum + plot.root.firstChild.offsetHeight, 0);
    const each = Math.max(LEAST_HEIGHT, Math.floor((height - TIME_AXIS - 2 - heads) / Math.max(1, open.length)));
    this.rebucket();
    for (const plot of open) plot.size(width, each + (plot.last ? TIME_AXIS : 0), "live");
  }

  rebucket() {
    const { machine, history, ghostHistory } = this.panel;
    if (!machine || !this.width) return;
    const pixels = Math.max(100, Math.round(this.width - 76));
    const count = pixels + 4;
    const columns = this.slots.map((name) => history.names.indexOf(name));
    const width = this.window / machine.period_s / pixels;
    this.buckets = new Buckets(history, ghostHistory, columns, width, count, this.ghostFrom());
    this.moved = true;
  }

  pause(is) {
    this.paused = is;
    this.button.setAttribute("aria-pressed", String(is));
    this.button.firstChild.textContent = is ? "Paused: go on " : "Pause ";
    this.moved = true;
  }

  onState(state) {
    this.moved ||= state.running === "diverged"; // its end is marked
    const ghost = state.ghost ? `${state.ghost.since_s}` : "";
    if (ghost !== this.ghost) {
      this.ghost = ghost;
      this.buckets?.restartGhost(this.ghostFrom());
      this.moved = true;
    }
  }

  ghostFrom() {
    return Math.round((this.panel.state?.ghost?.since_s ?? 0) / this.panel.machine.period_s);
  }

  step(now) {
    requestAnimationFrame(this.step);
    if (now - (this.told ?? 0) > LEGEND_MS) this.tell(now);
    const wanted = this.moved || this.plots.some((plot) => plot.dirty || (plot.axis.closing && !plot.folded));
    const { machine, history } = this.panel;
    if (!wanted || !machine || !this.buckets || this.panel.view !== "live") return;
    if (this.paused && !this.plots.some((plot) => plot.dirty)) return;
    this.moved = false;
    this.draw(now, machine.period_s, history);
    this.frames.drawn(now);
    this.panel.emit("drawn", { now, last: history.last });
  }

  draw(now, periodS, history) {
    if (!this.paused) this.buckets.update();
    const to = this.paused ? this.to : Math.max(history.last * periodS, this.window);
    this.to = to;
    const from = to - this.window;
    const gaps = history.gaps.filter(([, end]) => end * periodS > from);
    const dense = isDense(this.buckets);
    const lost = this.panel.state?.running === "diverged" ? history.last : 0;
    const seen = { from, to, now, periodS, ghost: Boolean(this.ghost), dense, gaps, lost };
    for (const plot of this.plots) plot.draw(this.buckets, seen);
  }

  /** The values of the legends and the rate of frames. */
  tell(now) {
    this.told = now;
    const { history } = this.panel;
    this.panel.measures.fps = this.frames.perSecond(now);
    const running = this.panel.state?.running === "running";
    const stopped = this.panel.state?.running === "stopped" && history.serial;
    const rate = stopped ? "the last run" : running && !this.paused ? `${this.panel.measures.fps} fps` : "";
    if (this.rate.textContent !== rate) this.rate.textContent = rate;
    if (!this.buckets) return;
    let serial = history.serial - 1;
    if (this.paused) {
      const under = this.plots[0]?.plot?.cursor.left ?? -1;
      const time = under >= 0 ? this.plots[0].plot.posToVal(under, "x") : this.to;
      serial = Math.min(history.find(time / this.panel.machine.period_s), history.serial - 1);
    }
    for (const plot of this.plots) plot.values(history, serial);
  }
}
