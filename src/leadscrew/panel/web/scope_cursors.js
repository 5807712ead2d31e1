/** Two cursors over the lanes, moved by mouse or keys, each on a row of the main capture. */

import { make } from "./elements.js";
import { duration } from "./format.js";
import { rowAt, timeOf } from "./measure.js";

/** One cursor: a flag that can be dragged and a line through all lanes. */
class Cursor {
  constructor(name, owner) {
    this.name = name;
    this.owner = owner;
    this.time = NaN;
    this.flag = make("span", { class: "scope-flag" }, name);
    this.element = make("div", {
      class: `scope-cursor scope-cursor-${name.toLowerCase()}`, role: "slider", tabIndex: 0,
      "aria-label": `Cursor ${name}`, "aria-orientation": "horizontal",
      title: "Drag, or arrow keys: one sample; Shift + arrow: ten; Page keys: a tenth of the picture",
      on: { pointerdown: (e) => this.grabbed(e), keydown: (e) => this.keyed(e) },
    }, this.flag);
  }

  grabbed(event) {
    event.preventDefault();
    this.element.focus();
    this.element.setPointerCapture(event.pointerId);
    const move = (e) => this.owner.put(this, this.owner.timeUnder(e.clientX));
    const end = () => this.element.removeEventListener("pointermove", move);
    this.element.addEventListener("pointermove", move);
    this.element.addEventListener("pointerup", end, { once: true });
    this.element.addEventListener("pointercancel", end, { once: true });
  }

  keyed(event) {
    const { range, limits } = this.owner.plot, wide = range[1] - range[0];
    const step = this.owner.step * (event.shiftKey ? 10 : 1);
    const to = {
      ArrowLeft: this.time - step, ArrowDown: this.time - step, ArrowRight: this.time + step, ArrowUp: this.time + step,
      PageUp: this.time - wide / 10, PageDown: this.time + wide / 10, Home: Math.max(range[0], limits[0]),
      End: range[1],
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.owner.put(this, to);
  }
}

export class Cursors {
  /**
   * @param {HTMLElement} layer lies over the lanes
   * @param {import("./scope_plot.js").ScopePlot} plot
   * @param {() => void} onMove told when a cursor moved
   */
  constructor(layer, plot, onMove) {
    Object.assign(this, { layer, plot, onMove, capture: null });
    this.pair = [new Cursor("A", this), new Cursor("B", this)];
    layer.append(...this.pair.map((c) => c.element));
    this.hide();
  }

  get a() { return this.pair[0].time; }
  get b() { return this.pair[1].time; }
  /** Seconds of one step of the keys: a row of the main capture. */
  get step() { return this.capture?.period_s ?? (this.plot.range[1] - this.plot.range[0]) / 1000; }

  /** On which capture's rows the cursors stand; they are put on the picture where they are not on it. */
  on(capture) {
    this.capture = capture;
    if (!capture) return this.hide();
    const [low, high] = this.plot.limits;
    if (this.pair.some((c) => !(c.time >= low && c.time <= high))) return this.bring();
    return this.place();
  }

  /** Puts both into what is shown. */
  bring() {
    const [low, high] = this.plot.range;
    this.pair[0].time = this.snapped(low + 0.25 * (high - low));
    this.pair[1].time = this.snapped(low + 0.75 * (high - low));
    this.place();
    this.onMove();
  }

  snapped(time) {
    const [low, high] = this.plot.limits, kept = Math.min(high, Math.max(low, time));
    return this.capture ? timeOf(this.capture, rowAt(this.capture, kept)) : kept;
  }

  put(cursor, time) {
    cursor.time = this.snapped(time);
    this.place();
    this.onMove();
  }

  timeUnder(clientX) {
    return this.plot.timeAt(clientX - this.layer.getBoundingClientRect().left);
  }

  hide() {
    for (const { element } of this.pair) element.hidden = true;
  }

  place() {
    if (!this.capture) return this.hide();
    for (const { element, time } of this.pair) {
      const at = this.plot.pixelOf(time);
      element.hidden = Number.isNaN(at);
      element.style.left = `${at}px`;
      element.setAttribute("aria-valuenow", String(time));
      element.setAttribute("aria-valuemin", String(this.plot.limits[0]));
      element.setAttribute("aria-valuemax", String(this.plot.limits[1]));
      element.setAttribute("aria-valuetext", `${duration(time)} from the trigger`);
    }
    return undefined;
  }
}
