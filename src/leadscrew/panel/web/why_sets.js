/** The fuzzy sets of each input as they are now, the value as a line, and the universe now against its full width. */

import { Picture, scale, tickText, ticks } from "./drawing.js";
import { make } from "./elements.js";
import { number, withUnit } from "./format.js";

export const READ =
  "Each shape is one word of the rules (such as NB, negative big): where the line of the present value cuts a shape, " +
  "its height tells how much that word is true.";
const READ_MOVED =
  "The strip on top is the full range of the input, the shaded part the range in use now. A variable universe " +
  "narrows it as the error falls, so that the same words act more finely.";

const LEFT = 34, RIGHT = 12, STRIP = 10;

/** Top of the sets, in pixels: room for the strip where the universe has moved. */
function layout(pen, contracted) {
  const top = contracted ? 44 : 24;
  return { left: LEFT, right: pen.width - RIGHT, top, bottom: pen.height - 22 };
}

function drawStrip(pen, input, box) {
  const full = scale(input.full_low, input.full_high, box.left, box.right);
  const [from, to, y] = [full(input.low), full(input.high), 14];
  const [a, b] = to - from < 2 ? [(from + to) / 2 - 1, (from + to) / 2 + 1] : [from, to];
  pen.line([[box.left, y], [box.right, y], [box.right, y + STRIP], [box.left, y + STRIP], [box.left, y]], "faint");
  pen.area([[a, y], [b, y], [b, y + STRIP], [a, y + STRIP]], "now", 0.55);
  pen.area([[a, y + STRIP], [b, y + STRIP], [box.right, box.top], [box.left, box.top]], "now", 0.07);
  pen.line([[a, y + STRIP], [box.left, box.top]], "faint", 1, [3, 3]);
  pen.line([[b, y + STRIP], [box.right, box.top]], "faint", 1, [3, 3]);
  const value = Math.min(box.right, Math.max(box.left, full(input.value)));
  pen.line([[value, y - 3], [value, y + STRIP + 3]], "value", 2);
  const share = (input.high - input.low) / (input.full_high - input.full_low);
  const whole = `${number(input.full_low, 3)} to ${withUnit(input.full_high, input.unit, 3)}`;
  const words = `full ${whole}, now ${number(100 * share, 3)} %`;
  pen.text(words, box.right, 6, { align: "right", size: 12, colour: "soft" });
}

function drawAxes(pen, input, box, x, y) {
  pen.line([[box.left, box.bottom], [box.right, box.bottom]], "soft");
  for (const degree of [0, 0.5, 1]) {
    pen.line([[box.left, y(degree)], [box.right, y(degree)]], "faint", degree ? 0.7 : 1);
    pen.text(String(degree), box.left - 5, y(degree), { align: "right", size: 12, colour: "soft" });
  }
  for (const tick of ticks(input.low, input.high, Math.max(3, Math.floor(pen.width / 110)))) {
    pen.line([[x(tick), box.bottom], [x(tick), box.bottom + 4]], "soft");
    pen.text(tickText(tick), x(tick), box.bottom + 12, { align: "center", size: 12, colour: "soft" });
  }
}

/** Where a set is highest: the middle of its top. */
export function peak(points) {
  const top = Math.max(...points.map((p) => p[1]));
  const high = points.filter((p) => p[1] >= top - 1e-9).map((p) => p[0]);
  return [(Math.min(...high) + Math.max(...high)) / 2, top];
}

function drawSets(pen, input, box, x, y) {
  const { context } = pen;
  context.save();
  context.beginPath();
  context.rect(box.left, box.top - 16, box.right - box.left, box.bottom - box.top + 17);
  context.clip();
  const sets = [...input.sets].sort((a, b) => a.degree - b.degree);
  for (const set of sets) {
    const line = set.points.map(([px, py]) => [x(px), y(py)]);
    const fires = set.degree > 0.0005;
    if (fires) {
      const closed = [...line, [line.at(-1)[0], y(0)], [line[0][0], y(0)]];
      pen.area(closed, "now", 0.08 + 0.3 * set.degree);
    }
    pen.line(line, fires ? "now" : "soft", fires ? 2 : 1);
  }
  context.restore();
}

function drawNames(pen, input, box, x) {
  let free = -Infinity;
  const named = input.sets.map((set) => {
    return { set, at: Math.min(box.right - 4, Math.max(box.left + 4, x(peak(set.points)[0]))) };
  });
  for (const { set, at } of named.sort((a, b) => a.at - b.at)) {
    const fires = set.degree > 0.0005;
    const words = fires ? `${set.name} ${set.degree.toFixed(2)}` : set.name;
    const half = pen.breadth(words, 12) / 2;
    const centre = Math.min(box.right - half, Math.max(box.left + half, at));
    if (centre - half < free && !fires) continue;
    pen.text(words, centre, box.top - 8,
      { align: "center", size: 12, bold: fires, colour: fires ? "ink" : "soft", halo: true });
    free = centre + half + 3;
  }
}

function drawInput(pen, { input, contracted }) {
  const box = layout(pen, contracted);
  const x = scale(input.low, input.high, box.left, box.right), y = scale(0, 1, box.bottom, box.top + 2);
  if (contracted) drawStrip(pen, input, box);
  drawAxes(pen, input, box, x, y);
  drawSets(pen, input, box, x, y);
  drawNames(pen, input, box, x);
  const at = Math.min(box.right, Math.max(box.left, x(input.value)));
  pen.line([[at, box.top], [at, box.bottom]], "value", 2);
  for (const set of input.sets) if (set.degree > 0.0005) pen.dot(at, y(set.degree), 4, "value");
}

/** True where the universe is not the full one, to a thousandth of its width. */
function moved(input) {
  const width = input.full_high - input.full_low;
  return Math.abs(input.low - input.full_low) > 1e-3 * width || Math.abs(input.high - input.full_high) > 1e-3 * width;
}

/** The view of the sets. */
export function setsView() {
  const element = make("div", { class: "why-sets" }), parts = new Map();
  const more = make("p", { class: "why-read", hidden: true }, READ_MOVED);
  const part = (name) => {
    const picture = new Picture(drawInput, 170, `Fuzzy sets of ${name}`);
    const caption = make("figcaption");
    const own = make("figure", { class: "why-figure" }, caption, picture.canvas);
    element.append(own);
    return { picture, caption, own, contracted: false };
  };
  return {
    name: "Sets",
    title: "Sets of the inputs",
    read: READ,
    element: make("div", {}, more, element),
    show(data) {
      const whole = data.inputs.filter((i) => [i.value, i.low, i.high, i.full_low, i.full_high].every(Number.isFinite)
        && i.high > i.low);
      const names = new Set(whole.map((i) => i.name));
      for (const [name, gone] of parts) if (!names.has(name)) { gone.own.remove(); parts.delete(name); }
      for (const input of whole) {
        if (!parts.has(input.name)) parts.set(input.name, part(input.name));
        const own = parts.get(input.name);
        own.contracted ||= moved(input);
        if (own.contracted) more.hidden = false;
        const beyond = input.value < input.low || input.value > input.high
          ? ", beyond the sets: taken at their edge" : "";
        own.caption.textContent = `${input.name} = ${withUnit(input.value, input.unit)}${beyond}`;
        own.picture.show({ input, contracted: own.contracted });
      }
    },
  };
}
