/** A circle run as a ball bar draws it: the deviation from the round, enlarged, around the turn. */

import { Picture } from "./drawing.js";
import { fill, make } from "./elements.js";
import { withUnit } from "./format.js";

export const READ =
  "The dashed ring is the perfect circle; the line shows how far the last turn was outside or inside it, enlarged " +
  "as the scale says. Spikes at 0, 90, 180 and 270 degrees are the axes turning round (friction); an oval leaning at " +
  "45 degrees means that one axis follows later than the other; a ring that is too small means that both follow late.";

// On either side of the perfect circle; the server chooses their size so that they hold the largest deviation.
const DIVISIONS = 4;

/** Places of points of a polar plot: the perfect circle at `ring` pixels, one division in so many pixels. */
export function polar(points, centre, ring, division, enlarge) {
  return points.map(([angle, deviation]) => {
    const radius = Math.max(0, ring + (deviation / enlarge) * division), turn = (angle * Math.PI) / 180;
    return [centre[0] + radius * Math.cos(turn), centre[1] - radius * Math.sin(turn)];
  });
}

function drawGrid(pen, centre, ring, division) {
  for (let k = -DIVISIONS; k <= DIVISIONS; k++) {
    pen.ring(...centre, ring + k * division, k === 0 ? "ink" : "faint", k === 0 ? 1.5 : 1, k === 0 ? [7, 5] : []);
  }
  const out = ring + DIVISIONS * division;
  for (const degrees of [0, 45, 90, 135, 180, 225, 270, 315]) {
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    const inner = ring - DIVISIONS * division;
    pen.line([[centre[0] + inner * c, centre[1] - inner * s], [centre[0] + out * c, centre[1] - out * s]], "faint",
      degrees % 90 ? 0.5 : 1);
    if (degrees % 90 === 0) pen.text(`${degrees}°`, centre[0] + (out + 16) * c, centre[1] - (out + 10) * s,
      { align: "center", size: 12, colour: "soft" });
  }
}

function drawRound(pen, { view, enlarge }) {
  const out = Math.min(pen.width, pen.height) / 2 - 26, centre = [pen.width / 2, pen.height / 2];
  const division = out / (2 * DIVISIONS + 1.2), ring = out - DIVISIONS * division;
  drawGrid(pen, centre, ring, division);
  const line = polar(view.points, centre, ring, division, enlarge);
  pen.line(line, "now", 2);
  if (line.length) pen.dot(...line.at(-1), 5, "value");
  pen.text(`1 division = ${withUnit(enlarge, "um", 3)}`, 4, 12, { bold: true });
  pen.text(`radius ${withUnit(view.radius, view.unit)}`, 4, 30, { colour: "soft" });
}

/** A figure in um; what is less than a tenth of a nanometre is shown as none. */
function micrometres(value) {
  return withUnit(Math.abs(value) < 1e-4 ? 0 : value, "um", 3);
}

function figures(view) {
  return Object.entries(view.figures ?? {}).map(([name, value]) =>
    make("div", {}, make("dt", {}, name),
      make("dd", {}, typeof value === "number" ? micrometres(value) : String(value))));
}

/** The view of the circle. */
export function circleView() {
  const picture = new Picture(drawRound, 400, "Polar plot of the deviation from the circle");
  const list = make("dl", { class: "why-figures" }), note = make("p", { class: "why-note" });
  return {
    name: "Circle",
    title: "Circle (ball bar)",
    read: READ,
    element: make("div", {}, picture.canvas, list, note),
    show(view) {
      note.textContent = view.text
        || (view.points?.length ? "" : "No turn yet: start the run and wait for the first full turn.");
      if (view.points) picture.show({ view, enlarge: view.enlarge || 1 });
      fill(list, ...figures(view));
    },
  };
}
