/** The scope: trigger, captured signals in lanes, cursors with what they read, overlays, save and load. */

import { button, fill, make } from "./elements.js";
import { unit } from "./format.js";
import { lanes } from "./measure.js";
import { Cursors } from "./scope_cursors.js";
import { Entries, overlaid, signalsOf } from "./scope_entries.js";
import { ScopePlot } from "./scope_plot.js";
import { Shelf } from "./scope_shelf.js";
import { ScopeTable } from "./scope_table.js";
import { TriggerForm } from "./scope_trigger.js";
import { savedOf } from "./saved.js";

const LANES = 3; // lanes drawn before anything is chosen, of
const EACH = 2; // signals each
const ROLES = ["command", "feedback", "error", "output"]; // the first to be drawn
const HELD = 8; // captures that the page keeps beside those on the screen; the server holds as many

/** Puts the scope into an element of the page. */
export function mountScope(element, panel) {
  new ScopeView(element, panel);
}

class ScopeView {
  constructor(element, panel) {
    Object.assign(this, { panel, entries: new Entries(), chosen: null, study: "" });
    Object.assign(this, { wanted: new Map(), asked: false, reading: false, last: [], kept: [] });
    element.classList.add("side", "scope");
    const names = ["trigger", "tools", "lanes", "layer", "empty", "table", "shelf"];
    const parts = Object.fromEntries(names.map((n) => [n, make("div", { class: `scope-${n}` })]));
    Object.assign(parts.lanes, { tabIndex: 0 });
    parts.lanes.setAttribute("role", "group");
    parts.lanes.setAttribute("aria-label",
      "Captured signals. Plus and minus zoom, arrow keys move, 0 shows all; Tab goes to the cursors");
    fill(element, parts.trigger, parts.tools,
      make("div", { class: "scope-picture" }, parts.lanes, parts.layer, parts.empty), parts.table, parts.shelf);
    parts.empty.textContent = "No capture yet: arm the scope or force one, or overlay a saved capture below.";
    this.empty = parts.empty;
    this.tableBox = parts.table;
    this.plot = new ScopePlot(parts.lanes, () => this.cursors?.place());
    this.cursors = new Cursors(parts.layer, this.plot, () => this.read());
    this.table = new ScopeTable(parts.table);
    this.trigger = new TriggerForm(parts.trigger, panel, () => this.signals());
    this.shelf = new Shelf(parts.shelf, panel, this.entries,
      { lay: (id, name) => this.lay(id, name), changed: () => this.redraw() });
    this.tools(parts.tools);
    panel.on("machine", () => this.machine());
    panel.on("capture", ({ capture }) => this.arrived(capture));
    for (const capture of panel.captures?.values() ?? []) this.arrived(capture);
    this.redraw();
  }

  tools(element) {
    const act = (text, title, go) => button(text, go, { title, "aria-label": title });
    this.count = make("summary", {}, "Signals");
    this.boxes = make("div", { class: "scope-boxes" });
    this.picker = make("details", { class: "scope-picker" }, this.count, this.boxes);
    this.picker.addEventListener("toggle", () => this.picker.open && this.fillBoxes());
    fill(element, this.picker, make("span", { class: "side-buttons", role: "group", "aria-label": "Zoom" },
      act("+", "Zoom in", () => this.plot.zoom(0.5)), act("−", "Zoom out", () => this.plot.zoom(2)),
      act("◀", "Earlier", () => this.plot.move(-0.25)), act("▶", "Later", () => this.plot.move(0.25)),
      act("All", "Show the whole capture", () => this.plot.all()),
      act("Cursors here", "Bring both cursors into the picture", () => this.cursors.bring())),
    make("span", { class: "side-soft" }, "Drag or wheel: zoom. Shift + drag: move. Double click: all."));
  }

  signals() {
    return signalsOf(this.panel.machine, this.entries.all);
  }

  /** The names of those drawn: chosen by hand, or the first of the plots with the trigger's. */
  drawn(all) {
    if (this.chosen) return all.filter((s) => this.chosen.has(s.signal));
    const held = all.filter((s) => !this.entries.main || this.entries.all.some((e) => e.names.includes(s.signal)));
    const rank = (s) => (ROLES.includes(s.role) ? ROLES.indexOf(s.role) : ROLES.length);
    const plotted = held.filter((s) => s.first), usual = plotted.length ? plotted : held;
    const first = lanes(usual).slice(0, LANES)
      .flatMap((lane) => [...lane.signals].sort((a, b) => rank(a) - rank(b)).slice(0, EACH));
    const own = this.entries.main?.capture.about?.trigger?.signal;
    const names = new Set([this.trigger?.trigger?.signal, own, ...this.kept, ...first.map((s) => s.signal)]);
    return held.filter((s) => names.has(s.signal));
  }

  machine() {
    const { study } = this.panel.machine;
    if (study !== this.study) this.chosen = null;
    this.kept = study === this.study && this.entries.main ? this.last : []; // another controller: what is seen stays
    this.study = study;
    this.redraw();
  }

  /** A capture came: one that was taken takes the place of the main one, one that was loaded lies over it. */
  arrived(capture) {
    if (this.wanted.has(capture.id)) this.over(capture, this.wanted.get(capture.id));
    else if (capture.loaded ?? savedOf(this.panel).loads > 0) return; // laid over when the answer names its number
    else this.entries.take(capture);
    this.wanted.delete(capture.id);
    this.forget();
    this.redraw();
  }

  /** Lays a capture over the main one, at once or as soon as its rows are there. */
  lay(id, name) {
    const capture = this.panel.captures.get(id);
    if (!capture) {
      this.wanted.set(id, name);
      return;
    }
    this.over(capture, name);
    this.redraw();
  }

  /** Lays a capture over the main one, and shows columns of it where it has none of those shown. */
  over(capture, name) {
    const before = this.drawn(this.signals()), alone = !this.entries.main;
    this.entries.lay(capture, name);
    const entry = this.entries.all.find((e) => e.id === capture.id), all = this.signals();
    if (alone) return this.shelf.say(`${name} is drawn.`);
    const { also, words } = overlaid(entry, before, all);
    if (also.length) this.chosen = new Set([...before.map((s) => s.signal), ...also]);
    this.shelf.say(words);
  }

  /** Lets go of captures that are not on the screen, so that a long day does not fill the memory. */
  forget() {
    const used = new Set(this.entries.all.map((e) => e.id)), { captures } = this.panel;
    const free = [...captures.keys()].filter((id) => !used.has(id));
    for (const id of free.slice(0, Math.max(0, free.length - HELD))) captures.delete(id);
  }

  fillBoxes() {
    const all = this.signals(), drawn = new Set(this.drawn(all).map((s) => s.signal));
    const find = make("input", { type: "search", placeholder: "find a signal", "aria-label": "Find a signal" });
    const lines = all.map((s) => {
      const box = make("input", { type: "checkbox", checked: drawn.has(s.signal), on: { change: () => {
        if (box.checked) drawn.add(s.signal);
        else drawn.delete(s.signal);
        this.chosen = drawn;
        this.redraw();
      } } });
      const named = s.label === s.signal ? s.signal : `${s.label} (${s.signal})`;
      return make("label", { data: { words: named.toLowerCase() } }, box, named,
        make("span", { class: "side-unit" }, unit(s.unit)));
    });
    find.addEventListener("input", () => {
      for (const line of lines) line.hidden = !line.dataset.words.includes(find.value.trim().toLowerCase());
    });
    fill(this.boxes, find, ...lines);
  }

  /** Once for all that changed before the next picture. */
  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      const all = this.signals(), drawn = this.drawn(all);
      this.last = drawn.map((s) => s.signal);
      this.count.textContent = `Signals: ${drawn.length} of ${all.length}`;
      this.empty.hidden = this.entries.shown.length > 0;
      this.tableBox.hidden = !this.empty.hidden;
      this.plot.show(this.entries, this.entries.shown.length ? drawn : [], this.trigger.trigger);
      this.cursors.on((this.entries.main?.visible ? this.entries.main : this.entries.shown[0])?.capture ?? null);
      this.shelf.show();
      this.read();
    });
  }

  /** What the cursors read, once for each picture however often they are moved. */
  read() {
    if (this.reading) return;
    this.reading = true;
    requestAnimationFrame(() => {
      this.reading = false;
      this.table.show(this.plot.legend(this.entries), this.entries.main, this.cursors.a, this.cursors.b);
    });
  }
}
