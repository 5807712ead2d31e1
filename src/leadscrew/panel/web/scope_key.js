/** The short piece of line that stands for a signal: its colour, and the dashes of the capture that it is of. */

const SVG = "http://www.w3.org/2000/svg";

/** @param {string} colour @param {number[] | null} dash as on the plot */
export function lineKey(colour, dash) {
  const picture = document.createElementNS(SVG, "svg"), line = document.createElementNS(SVG, "line");
  const set = (element, values) => Object.entries(values).forEach(([name, value]) => element.setAttribute(name, value));
  set(picture, { class: "scope-key", width: 30, height: 6, viewBox: "0 0 30 6", "aria-hidden": "true" });
  set(line, { x1: 0, y1: 3, x2: 30, y2: 3, stroke: colour, "stroke-width": 2.5,
    "stroke-dasharray": dash ? dash.join(" ") : "none" });
  picture.append(line);
  return picture;
}
