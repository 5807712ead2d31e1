// The left column: every parameter with its name, unit, help, allowed range and default; changed ones are marked.

import { Row } from "./parameter.js";

const OPEN = ["controller", "reference"];
const TITLES = {
  controller: "Controller", reference: "Command (reference)", disturbance: "Disturbance", plant: "Machine (plant)",
  sensor: "Sensor", actuator: "Actuator", scenario: "Scenario", wrapped: "Controller",
};

export function mountParameters(element, panel) {
  element.innerHTML = `<div class="tools">
      <button type="button" id="undo" aria-keyshortcuts="Control+Z" disabled>Undo <kbd>Ctrl+Z</kbd></button>
      <button type="button" id="redo" aria-keyshortcuts="Control+Y" disabled>Redo <kbd>Ctrl+Y</kbd></button>
      <input id="search" type="search" placeholder="Search parameters ( / )" aria-label="Search parameters"
        autocomplete="off">
    </div><div class="scroll" id="parameters"><p class="empty">Waiting for the machine.</p></div>`;
  const view = new View(element, panel);
  for (const what of ["undo", "redo"]) {
    element.querySelector(`#${what}`).addEventListener("click", () => panel.tell(what));
  }
  element.querySelector("#search").addEventListener("input", () => view.filter());
  panel.on("machine", () => view.renew());
  for (const kind of ["state", "writer", "link"]) panel.on(kind, () => view.show());
}

class View {
  constructor(element, panel) {
    this.panel = panel;
    this.box = element.querySelector("#parameters");
    this.search = element.querySelector("#search");
    this.undo = element.querySelector("#undo");
    this.redo = element.querySelector("#redo");
    this.rows = new Map();
    this.open = new Map(OPEN.map((group) => [group, true]));
  }

  renew() {
    const { machine } = this.panel;
    const shape = JSON.stringify(machine.parameters.map(({ value, ...rest }) => rest));
    if (shape !== this.shape) {
      this.shape = shape;
      this.build(machine.parameters);
    }
    this.started = new Map(machine.parameters.map(({ key, value }) => [key, value]));
    this.changed = null;
    this.show();
    this.filter();
  }

  build(parameters) {
    const top = this.box.scrollTop;
    this.rows.clear();
    this.groups = new Map();
    const first = (group) => (OPEN.includes(group) ? OPEN.indexOf(group) : OPEN.length);
    const place = ({ group, type }) => 2 * first(group) + (type === "array" ? 1 : 0); // tables behind what can be set
    for (const parameter of [...parameters].sort((a, b) => place(a) - place(b))) {
      const row = new Row(parameter, this.panel);
      this.rows.set(parameter.key, row);
      this.group(parameter.group).append(row.root);
    }
    this.box.replaceChildren(...[...this.groups.values()].map(({ root }) => root));
    if (!parameters.length) this.box.textContent = "This machine has no parameters to set.";
    this.box.scrollTop = top;
  }

  /** Groups of a machine that has none of the usual ones are all open. */
  isOpen(name) {
    return this.open.get(name) ?? !OPEN.some((group) => this.groups.has(group));
  }

  group(name) {
    if (!this.groups.has(name)) {
      const root = document.createElement("details");
      root.open = this.isOpen(name);
      const summary = document.createElement("summary");
      const title = document.createElement("span");
      title.textContent = TITLES[name] ?? name;
      const count = document.createElement("span");
      count.className = "count";
      summary.append(title, count);
      root.append(summary);
      summary.addEventListener("click", () => { if (!this.search.value) this.open.set(name, !root.open); });
      this.groups.set(name, { root, count });
    }
    return this.groups.get(name).root;
  }

  /** Values as the machine has them now: those that differ from the message "machine" come with every state. */
  show() {
    const { state, connected, isWriter, machine } = this.panel;
    const may = Boolean(connected && isWriter && machine && state);
    const lost = state?.running === "diverged"; // only a reset is possible then
    this.undo.disabled = !may || lost || !state.can_undo;
    this.redo.disabled = !may || lost || !state.can_redo;
    const changed = JSON.stringify([state?.changed ?? null, may]);
    if (changed === this.changed || !this.started) return;
    this.changed = changed;
    for (const [key, row] of this.rows) {
      row.show(state?.changed?.[key] ?? this.started.get(key), may);
    }
    this.counts();
  }

  counts() {
    for (const { root, count } of this.groups?.values() ?? []) {
      const rows = root.querySelectorAll(".param").length;
      const changed = root.querySelectorAll(".param.changed").length;
      count.textContent = changed ? `${rows}, ${changed} changed` : String(rows);
    }
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of this.rows.values()) row.root.hidden = !words.every((word) => row.words.includes(word));
    for (const [name, { root }] of this.groups ?? []) {
      const found = root.querySelector(".param:not([hidden])");
      root.hidden = !found;
      root.open = words.length ? Boolean(found) : this.isOpen(name);
    }
  }
}
