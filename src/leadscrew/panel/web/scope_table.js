/** What the cursors read: a line for each signal of each capture. */

import { fill, make } from "./elements.js";
import { duration, frequency, number, unit } from "./format.js";
import { reading } from "./measure.js";
import { lineKey } from "./scope_key.js";

const HEADS = [
  ["signal", ""], ["unit", ""], ["at A", "value at cursor A"], ["at B", "value at cursor B"],
  ["B - A", "difference of both"],
  ["min", "least value between the cursors"], ["max", "greatest value between the cursors"],
  ["mean", "mean between the cursors"], ["rms", "root of the mean square between the cursors, about zero"],
];

export class ScopeTable {
  constructor(element) {
    this.times = make("p", { class: "scope-times", role: "status", "aria-live": "off" });
    this.body = make("tbody");
    const head = make("tr", {}, ...HEADS.map(([text, title]) => make("th", { scope: "col", title }, text)));
    fill(element, this.times, make("div", { class: "scope-scroll" },
      make("table", { class: "scope-table", "aria-label": "Values at and between the cursors" },
        make("thead", {}, head), this.body)));
  }

  /** @param {object[]} legend of the plot, @param {number} a and @param {number} b seconds from the trigger */
  show(legend, main, a, b) {
    const known = Number.isFinite(a) && Number.isFinite(b);
    this.times.textContent = known
      ? `A ${duration(a)}   B ${duration(b)}   dt ${duration(b - a)}   1/dt ${frequency(b - a)}` : "";
    const rows = legend.flatMap((lane) => lane.entries.flatMap((entry) =>
      lane.signals.map((s) => this.row(s, entry, entry === main, a, b))));
    fill(this.body, ...rows);
  }

  row(signal, entry, isMain, a, b) {
    const values = entry.values(signal);
    if (!values) return null;
    const found = reading(entry.capture, values, a - entry.shift, b - entry.shift);
    const key = lineKey(signal.colour, entry.dash);
    const name = make("th", { scope: "row", title: signal.signal }, key,
      isMain ? signal.label : `${signal.label}, ${entry.name}`);
    const cells = [found.a, found.b, found.difference, found.min, found.max, found.mean, found.rms];
    return make("tr", {}, name, make("td", {}, unit(signal.unit)), ...cells.map((v) => make("td", {}, number(v, 5))));
  }
}
