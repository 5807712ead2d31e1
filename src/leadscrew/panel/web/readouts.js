// The numbers an operator reads at a glance, above the plots: four times a second the mean of what came since the last
// showing, or of a signal that swings about 0 the value farthest from it.

import { fill, make, put } from "./elements.js";
import { steady, unit } from "./format.js";

const EVERY_MS = 250;
const MOST = 6;

/** What is shown: as the profile says, else the first signals that are drawn. */
export function readoutsOf({ readouts, plots }) {
  if (readouts?.length) return readouts;
  const found = new Map();
  for (const { signal, label, unit: of, factor, role } of plots.flatMap((plot) => plot.traces)) {
    const shows = role === "error" ? "peak" : "mean";
    if (!found.has(signal)) found.set(signal, { label, source: signal, unit: of, factor: factor ?? 1, shows });
  }
  return [...found.values()].slice(0, MOST);
}

/** Mean, or value farthest from 0, of the rows of a column from a serial number on; NaN where there are none. */
export function over(history, column, from, shows) {
  let sum = 0, count = 0, peak = NaN;
  for (let serial = Math.max(from, history.oldest); serial < history.serial; serial += 1) {
    const value = history.value(column, serial);
    if (value !== value) continue;
    sum += value;
    count += 1;
    if (!(Math.abs(value) <= Math.abs(peak))) peak = value;
  }
  return shows === "peak" ? peak : count ? sum / count : NaN;
}

/** The number of a readout; `parameter(key)` gives the value of what is no column. */
export function valueOf(readout, history, from, parameter) {
  const of = (name, shows) => (history.rings.has(name) ? over(history, name, from, shows) : parameter(name));
  const value = of(readout.source, readout.shows) * readout.factor;
  return readout.per ? value / of(readout.per, "mean") : value;
}

function words(value, { decimals }) {
  if (!Number.isFinite(value)) return "-";
  if (!Number.isInteger(decimals) || Math.abs(value) >= 1e6) return steady(value);
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text; // no -0.0
}

export function mountReadouts(element, panel) {
  let shown = [], from = 0, to = 0, history = null, fresh = true;
  const parameter = (key) => panel.state?.changed?.[key]
    ?? panel.machine.parameters.find((p) => p.key === key)?.value ?? NaN;
  const build = () => {
    shown = readoutsOf(panel.machine).map((readout) => ({ readout, value: make("output", { "aria-live": "off" }) }));
    fill(element, ...shown.map(({ readout, value }) => {
      const how = readout.shows === "peak" ? "the value farthest from 0" : "the mean";
      const title = `${readout.source}: ${how} of the last quarter of a second`;
      return make("div", { title }, make("span", {}, readout.label), value, make("i", {}, unit(readout.unit)));
    }));
    element.hidden = !shown.length;
    fresh = true;
  };
  const tell = () => {
    if (history !== panel.history || history.serial < to) {
      history = panel.history;
      from = to = Math.max(0, history.serial - 1);
      fresh = true;
    }
    if (history.serial > to) [from, to, fresh] = [to, history.serial, true];
    if (!fresh || !panel.machine) return;
    fresh = false;
    for (const { readout, value } of shown) put(value, words(valueOf(readout, history, from, parameter), readout));
  };
  panel.on("machine", build);
  panel.on("state", () => { fresh = true; });
  setInterval(tell, EVERY_MS);
}
