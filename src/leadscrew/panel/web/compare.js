// Now against the previous setting: rms and worst error since the change.

import { put } from "./elements.js";
import { clock, number, unit } from "./format.js";

const MODES = [
  ["previous", "Previous", "Dashed: what the setting before the last change would do now"],
  ["pinned", "Pinned", "Dashed: the setting that is pinned, whatever is changed after it"],
  ["off", "Off", "No comparison"],
];

export function mountCompare(element, panel) {
  element.innerHTML = `<h2>Compare with <span role="group" aria-label="Compare with"></span></h2>
    <p class="about"></p>
    <table hidden><thead><tr><th scope="col">error</th><th scope="col">now</th><th scope="col">previous</th>
    <th scope="col">difference</th></tr></thead><tbody>
    <tr><th scope="row">rms</th><td></td><td></td><td></td></tr>
    <tr><th scope="row">worst</th><td></td><td></td><td></td></tr></tbody></table>`;
  const buttons = MODES.map(([mode, words, title]) => {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: words, title });
    button.dataset.mode = mode;
    button.addEventListener("click", async () => {
      if (await panel.tell("compare", { mode })) panel.compareMode = mode;
      show(element, buttons, panel);
    });
    return button;
  });
  panel.compareMode = "previous";
  element.querySelector("h2 span").append(...buttons);
  for (const kind of ["state", "machine", "writer", "link"]) panel.on(kind, () => show(element, buttons, panel));
}

function show(element, buttons, panel) {
  const { state, machine } = panel;
  const may = panel.connected && panel.isWriter && Boolean(machine?.can?.compare);
  const mode = state?.ghost?.mode ?? state?.compare ?? panel.compareMode;
  for (const button of buttons) {
    button.disabled = !may;
    button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
  }
  const about = element.querySelector(".about");
  const table = element.querySelector("table");
  element.hidden = machine ? !machine.can.compare : false;
  const figures = state?.figures;
  table.hidden = !figures;
  put(about, words(state, figures));
  if (!figures) return;
  const cells = element.querySelectorAll("td");
  const values = [figures.rms, figures.rms_ghost, figures.worst, figures.worst_ghost];
  put(element.querySelector("thead th"), unit(figures.unit) ? `error, ${unit(figures.unit)}` : "error");
  for (const [row, [now, before]] of [[0, values.slice(0, 2)], [1, values.slice(2)]]) {
    put(cells[3 * row], has(now) ? number(now, 4) : "-");
    put(cells[3 * row + 1], has(before) ? number(before, 4) : "-");
    const part = has(now) && has(before) && before !== 0 ? 100 * (now / before - 1) : NaN;
    put(cells[3 * row + 2], Number.isFinite(part) ? percent(part) : "-");
    cells[3 * row + 2].className = !Number.isFinite(part) || Math.abs(part) < 0.05 ? "" : part < 0 ? "better" : "worse";
  }
}

function words(state, figures) {
  if (state?.ghost) return `Dashed: ${state.ghost.label}. Since ${clock(state.ghost.since_s)}.`;
  if (figures) return `Since ${clock(figures.since_s)}. Change a parameter of the controller to compare.`;
  return "Change a parameter of the controller while the machine runs: the previous setting runs on beside it, dashed.";
}

/** A difference in %; as a factor where it is beyond 1000 %. */
function percent(part) {
  if (part > 1000) return part > 1e6 ? "far larger" : `× ${number(1 + part / 100, 3)}`;
  const text = part.toFixed(1);
  return `${text === "-0.0" ? "0.0" : part >= 0.05 ? `+${text}` : text} %`;
}

function has(value) { return typeof value === "number" && Number.isFinite(value); }
