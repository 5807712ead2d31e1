/**
 * Pictures of the Why view on a canvas: sharp on every screen, redrawn when their place or their data change.
 * Colours are those of the page (custom properties of style.css and side.css), read when a picture is drawn.
 */

import { make } from "./elements.js";
import { number } from "./format.js";

const FONT = "system-ui, 'Segoe UI', Roboto, 'Noto Sans', sans-serif";

/** A canvas that draws with `draw(pen, data)` whenever `show(data)` is called or its size changes. */
export class Picture {
  /**
   * @param {(pen: Pen, data: object) => void} draw
   * @param {number} height in CSS pixels
   * @param {string} label what is drawn, for those who cannot see it
   */
  constructor(draw, height, label) {
    this.draw = draw;
    this.height = height;
    this.data = null;
    this.asked = false;
    this.canvas = make("canvas", { class: "side-picture", role: "img", "aria-label": label });
    this.canvas.style.height = `${height}px`;
    new ResizeObserver(() => this.again()).observe(this.canvas);
  }

  show(data) {
    this.data = data;
    this.again();
  }

  again() {
    if (this.asked || !this.data) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      const width = this.canvas.clientWidth, dense = window.devicePixelRatio || 1;
      if (width === 0) return;
      const [w, h] = [Math.round(width * dense), Math.round(this.height * dense)];
      if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
      const context = this.canvas.getContext("2d");
      context.setTransform(dense, 0, 0, dense, 0, 0);
      context.clearRect(0, 0, width, this.height);
      this.draw(new Pen(context, width, this.height, getComputedStyle(this.canvas)), this.data);
    });
  }
}

/** Lines, areas and words on a canvas, in CSS pixels. */
class Pen {
  constructor(context, width, height, style) {
    Object.assign(this, { context, width, height, style });
    context.lineJoin = "round";
    context.textBaseline = "middle";
  }

  /** A colour of the page by the name of its custom property without `--side-`. */
  colour(name) {
    return this.style.getPropertyValue(`--side-${name}`).trim() || this.style.color;
  }

  path(points, closed = false) {
    const { context } = this;
    context.beginPath();
    points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (closed) context.closePath();
    return context;
  }

  line(points, colour, width = 1, dash = []) {
    if (points.length < 2) return;
    const context = this.path(points);
    context.setLineDash(dash);
    context.strokeStyle = this.colour(colour);
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  area(points, colour, alpha) {
    const context = this.path(points, true);
    context.globalAlpha = alpha;
    context.fillStyle = this.colour(colour);
    context.fill();
    context.globalAlpha = 1;
  }

  dot(x, y, radius, colour) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = this.colour(colour);
    context.fill();
    context.strokeStyle = this.colour("ground");
    context.lineWidth = 1.5;
    context.stroke();
  }

  ring(x, y, radius, colour, width = 1, dash = []) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.setLineDash(dash);
    context.strokeStyle = this.colour(colour);
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  /** Words at a place; `align` is left, center or right; `halo` puts the ground behind them. */
  text(words, x, y, { colour = "ink", align = "left", size = 12, bold = false, halo = false } = {}) {
    const { context } = this;
    context.font = `${bold ? "600 " : ""}${size}px ${FONT}`;
    context.textAlign = align;
    if (halo) {
      context.strokeStyle = this.colour("ground");
      context.lineWidth = 4;
      context.strokeText(words, x, y);
    }
    context.fillStyle = this.colour(colour);
    context.fillText(words, x, y);
  }

  breadth(words, size = 12) {
    this.context.font = `${size}px ${FONT}`;
    return this.context.measureText(words).width;
  }
}

/** A straight scale from values to pixels, clamped where asked. */
export function scale(low, high, from, to) {
  const slope = (to - from) / (high - low || 1);
  return (value) => from + (value - low) * slope;
}

/** Round values inside a range, about `count` of them. */
export function ticks(low, high, count = 5) {
  const raw = (high - low) / count;
  if (!(raw > 0) || !Number.isFinite(raw)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((m) => m * power >= raw * 0.999) ?? 10);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) out.push(k * step);
  return out;
}

/** A tick's words: no "0.30000000000000004". */
export function tickText(value) {
  return number(Number(value.toPrecision(3)), 3);
}

/**
 * A half width about zero that follows the data: it opens at once and closes only when less than a third is used,
 * so that the picture does not tremble.
 */
export class Span {
  constructor() {
    this.half = 0;
  }

  follow(largest) {
    if (!(largest > 0) || !Number.isFinite(largest)) return this.half || 1;
    if (1.04 * largest > this.half || largest < this.half / 3) {
      const power = 10 ** Math.floor(Math.log10(largest * 1.15));
      this.half = power * ([1, 1.5, 2, 3, 5, 7].find((m) => m * power >= largest * 1.15) ?? 10);
    }
    return this.half;
  }
}
