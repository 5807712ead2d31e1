// One parameter: entry field and slider, a switch, or a list of options; what was refused is put back with the reason beside it.

import { bounds, brief, exact, number, typed, unit, withUnit } from "./format.js";
import { STEPS, scaleOf } from "./slider.js";

const HOW_MS = 4000;

function element(tag, name, text) {
  const made = document.createElement(tag);
  if (name) made.className = name;
  if (text) made.textContent = text;
  return made;
}

export class Row {
  constructor(parameter, panel) {
    this.parameter = parameter;
    this.panel = panel;
    this.words = `${parameter.key} ${parameter.label} ${parameter.doc ?? ""} ${parameter.unit ?? ""}`.toLowerCase();
    this.root = element("div", "param");
    this.root.dataset.key = parameter.key;
    this.id = `param-${parameter.key.replace(/[^\w-]/g, "-")}`;
    const head = element("div", "head");
    const label = element("label");
    for (const part of (parameter.label || parameter.key).split(/(?<=[._])/)) {
      label.append(part, document.createElement("wbr")); // long names break behind a point or a line
    }
    label.htmlFor = this.id;
    label.title = parameter.key;
    this.mark = element("button", "mark");
    this.mark.type = "button";
    this.mark.hidden = true;
    this.mark.addEventListener("click", () => this.send(parameter.default));
    head.append(label, element("span", "unit", unit(parameter.unit)), this.mark);
    this.doc = element("p", "doc", this.help());
    this.doc.id = `${this.id}-doc`;
    this.error = element("p", "error");
    this.error.setAttribute("role", "alert");
    this.root.append(head, this.entry(), this.doc, this.error);
  }

  help() {
    const { doc, live, why_not: why, type } = this.parameter;
    const sentence = doc ? doc.charAt(0).toUpperCase() + doc.slice(1).replace(/\.$/, "") : "";
    const range = type === "float" || type === "int" ? bounds(this.parameter) : "";
    const parts = [sentence, range && `${range}${type === "int" ? ", whole" : ""}`].filter(Boolean).join("; ");
    return live ? parts : `${parts ? `${parts}. ` : ""}Fixed in the run: ${why || "it cannot be changed now"}.`;
  }

  entry() {
    const { type } = this.parameter;
    const box = element("div", "entry");
    if (type === "array") {
      this.table = element("output", "table");
      this.table.id = this.id;
      box.append(this.table);
      return box;
    }
    this.field = element(type === "choice" ? "select" : "input");
    this.field.id = this.id;
    this.field.setAttribute("aria-describedby", `${this.id}-doc`);
    if (type === "bool") return this.toggle(box);
    if (type === "choice") return this.options(box);
    Object.assign(this.field, { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false });
    this.field.addEventListener("focus", () => this.write(this.value)); // all digits while it is edited
    this.field.addEventListener("blur", () => { if (!this.sending) this.write(this.value); });
    this.field.addEventListener("change", () => this.enter());
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.field.blur();
      if (event.key === "Escape") {
        this.back(); // what was typed is not sent
        this.field.blur();
      }
    });
    box.append(this.field);
    this.scale = scaleOf(this.parameter);
    if (this.scale) box.append(this.makeSlider());
    return box;
  }

  toggle(box) {
    this.field.type = "checkbox";
    this.field.setAttribute("role", "switch");
    this.field.addEventListener("change", () => this.send(this.field.checked));
    this.said = element("span", "said");
    box.append(this.field, this.said);
    return box;
  }

  options(box) {
    for (const name of this.parameter.choices) this.field.append(new Option(name, name));
    this.field.addEventListener("change", () => this.send(this.field.value));
    box.append(this.field);
    return box;
  }

  makeSlider() {
    this.slider = element("input");
    Object.assign(this.slider, { type: "range", min: 0, max: STEPS, step: 1 });
    this.slider.setAttribute("aria-label", `${this.parameter.label || this.parameter.key}, slider`);
    this.slider.addEventListener("input", () => {
      this.sliding = true;
      this.field.value = exact(this.scale.value(Number(this.slider.value)));
      this.slider.setAttribute("aria-valuetext", this.field.value);
    });
    this.slider.addEventListener("change", () => {
      this.sliding = false;
      this.send(this.scale.value(Number(this.slider.value)));
    });
    return this.slider;
  }

  enter() {
    const value = typed(this.field.value);
    if (Number.isNaN(value)) {
      this.refuse(`"${this.field.value}" is not a finite number.`);
      return;
    }
    if (value !== this.value) this.send(value);
    else this.back();
  }

  async send(value) {
    this.error.textContent = "";
    this.sending = true;
    this.root.classList.add("sending");
    try {
      const result = await this.panel.send("set", { changes: { [this.parameter.key]: value } });
      this.sending = false;
      this.show(result?.new?.[this.parameter.key] ?? value, this.may);
      this.tell(result?.how);
    } catch (error) {
      this.sending = false;
      this.refuse(error.message);
    } finally {
      this.root.classList.remove("sending");
    }
  }

  refuse(sentence) {
    this.back();
    this.error.textContent = sentence;
  }

  /** How the change came in, for a moment. */
  tell(how) {
    const words = { ramped: "brought in within 0.1 s", "at once": "set at once" }[how];
    if (!words) return;
    this.mark.dataset.how = words;
    clearTimeout(this.later);
    this.later = setTimeout(() => delete this.mark.dataset.how, HOW_MS);
  }

  back() {
    this.sliding = false;
    this.write(this.value);
  }

  show(value, may) {
    this.value = value;
    this.may = may;
    const { live, default: start } = this.parameter;
    for (const input of [this.field, this.slider]) if (input) input.disabled = !may || !live;
    const changed = JSON.stringify(value) !== JSON.stringify(start);
    this.root.classList.toggle("changed", changed);
    this.mark.hidden = !changed;
    this.mark.disabled = !may || !live;
    if (changed) {
      this.mark.textContent = `default ${this.table ? "table" : number(start, 6)}`;
      this.mark.title = `Changed. Back to the default, ${withUnit(start, this.parameter.unit, 8)}`;
    }
    const typing = document.activeElement === this.field && this.field.type === "text";
    const editing = this.sliding || this.sending || typing;
    if (!editing) this.write(value);
  }

  write(value) {
    if (this.table) {
      this.table.textContent = tableWords(value ?? this.parameter.default);
      return;
    }
    if (this.field.type === "checkbox") {
      this.field.checked = Boolean(value);
      this.said.textContent = value ? "on" : "off";
      return;
    }
    if (this.parameter.type === "choice") {
      this.field.value = value;
      return;
    }
    const text = document.activeElement === this.field ? exact(value) : brief(value);
    if (this.field.value !== text) this.field.value = text;
    this.field.title = exact(value);
    if (this.slider) this.slider.value = String(this.scale.position(value));
  }
}

function tableWords(value) {
  if (!Array.isArray(value)) return typeof value === "string" ? value : "table of numbers";
  const shape = [];
  for (let part = value; Array.isArray(part); part = part[0]) shape.push(part.length);
  const count = shape.reduce((a, b) => a * b, 1);
  return shape.length > 1 ? `table of ${count} numbers (${shape.join(" × ")})` : `table of ${count} numbers`;
}
