// Disturbances of the machine: a button each, with its numbers.

import { make } from "./elements.js";
import { bounds, exact, typed, unit } from "./format.js";

export function mountDisturb(element, panel) {
  element.innerHTML = '<h2>Disturb the machine</h2><div class="cards"></div>';
  const cards = element.querySelector(".cards");
  let shown = "";
  panel.on("machine", (machine) => {
    const of = JSON.stringify(machine.disturbances);
    if (of === shown) return;
    shown = of;
    const kept = [...cards.querySelectorAll("input")].map((field) => [field.id, field.value, field.defaultValue]);
    cards.replaceChildren(...machine.disturbances.map((disturbance) => card(disturbance, panel)));
    for (const [id, value, first] of kept) {
      const field = document.getElementById(id);
      if (field && value !== first && field.defaultValue === first) field.value = value; // as typed
    }
    element.hidden = !machine.disturbances.length;
    allow(cards, panel);
  });
  for (const kind of ["state", "writer", "link"]) panel.on(kind, () => allow(cards, panel));
}

function allow(cards, panel) {
  const may = panel.connected && panel.isWriter && ["running", "held"].includes(panel.state?.running);
  for (const button of cards.querySelectorAll("button")) {
    button.disabled = !may;
    button.title = may ? "" : panel.isWriter ? "Start the machine first." : "Take control first.";
  }
}

function card(disturbance, panel) {
  const inputs = new Map(disturbance.fields.map((field) => [field, entry(disturbance, field)]));
  const error = make("p", { class: "error", role: "alert" });
  const box = make("form", { class: "card", noValidate: true },
    make("button", { type: "submit" }, disturbance.label), make("p", { class: "doc" }, disturbance.doc),
    make("div", { class: "fields" }, ...[...inputs.values()].map((input) => input.parentElement)), error);
  box.addEventListener("submit", async (event) => {
    event.preventDefault();
    error.textContent = "";
    const values = {};
    for (const [field, input] of inputs) {
      values[field.name] = typed(input.value);
      if (Number.isNaN(values[field.name])) {
        error.textContent = `${field.label}: "${input.value}" is not a finite number.`;
        input.focus();
        return;
      }
    }
    try {
      await panel.send("disturb", { name: disturbance.name, fields: values });
    } catch (refused) {
      error.textContent = refused.message;
    }
  });
  return box;
}

function entry(disturbance, field) {
  const name = unit(field.unit) ? `${field.label}, ${unit(field.unit)}` : field.label;
  const input = make("input", {
    type: "text", inputMode: "decimal", autocomplete: "off", defaultValue: exact(field.value),
    id: `disturb-${disturbance.name}-${field.name}`,
  });
  const title = `${field.doc ?? ""} Allowed: ${bounds(field)}.`.trim();
  make("label", { title }, make("span", {}, name), input);
  return input;
}
