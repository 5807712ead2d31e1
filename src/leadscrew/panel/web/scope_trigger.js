/** The trigger: what the scope waits for, and what it is doing now in words. */

import { button, choice, fill, labelled, make } from "./elements.js";
import { number, typed, unit, withUnit } from "./format.js";

const SLOPES = [["rising", "rising"], ["falling", "falling"], ["either", "either"]];
const MODES = [["single", "single"], ["normal", "normal"], ["auto", "auto"]];

/** A field for a number with its unit. */
function numeric(label, value, of, title) {
  const field = make("input", { type: "text", inputMode: "decimal", value, title, size: 7, autocomplete: "off" });
  const shown = make("span", { class: "side-unit" }, of);
  const place = labelled(label, field);
  place.lastChild.append(shown);
  return { field, place, shown, get value() { return typed(field.value); } };
}

/** What the scope does, as a sentence. */
export function words(scope, signals) {
  if (!scope?.phase) return "The scope is not ready.";
  const trigger = scope.trigger, known = signals.find((s) => s.signal === trigger?.signal);
  const factor = known?.factor ?? 1;
  const way = { rising: "to rise through", falling: "to fall through", either: "to pass" }[trigger?.slope];
  const what = trigger
    ? `${known?.label ?? trigger.signal} ${way} ${withUnit(trigger.level * factor, known?.unit ?? "")}` : "";
  const taken = scope.count ? ` ${scope.count} taken.` : "";
  const base = {
    idle: "Idle: arm the scope, or force a capture now.",
    armed: `Armed: waits for ${what}.${taken}`,
    taking: `Triggered: ${Math.round(100 * (scope.share ?? 0))} % of the capture is there.${taken}`,
    done: `Done: one capture taken.`,
  }[scope.phase] ?? scope.phase;
  return scope.message ? `${base} ${scope.message}` : base;
}

export class TriggerForm {
  /** @param {HTMLElement} element @param {object} panel @param {() => object[]} signals those that can be chosen */
  constructor(element, panel, signals) {
    Object.assign(this, { panel, signals });
    this.signal = make("select", { on: { change: () => this.relabel() } });
    this.slope = choice(SLOPES, "rising");
    this.mode = choice(MODES, "single");
    this.mode.title = "single: one capture; normal: one at every trigger; auto: also where no trigger comes";
    this.level = numeric("Level", "0", "", "The signal has to pass this value");
    this.pre = numeric("Before", "20", "%", "Share of the capture that lies before the trigger");
    this.length = numeric("Length", "1", "s", "Length of the whole capture");
    this.wrong = make("p", { class: "error", role: "alert" });
    this.said = make("p", { class: "scope-state", role: "status" });
    this.arm = button("Arm", () => {}, { type: "submit", class: "main" }); // Enter in a field arms too
    this.disarm = button("Disarm", () => panel.tell("disarm"));
    this.force = button("Force", () => this.now(),
      { title: "Take a capture now, without waiting for the trigger" });
    const fields = [labelled("Signal", this.signal), this.level.place, labelled("Slope", this.slope),
      labelled("Mode", this.mode), this.pre.place, this.length.place];
    const heard = { submit: (e) => { e.preventDefault(); this.send(); }, input: () => { this.touched = true; } };
    const acts = make("div", { class: "side-buttons", role: "group", "aria-label": "Trigger" });
    acts.append(this.arm, this.disarm, this.force);
    const form = make("form", { class: "scope-form", on: heard }, ...fields, acts);
    fill(element, form, this.wrong, this.said);
    panel.on("machine", () => this.refill());
    panel.on("state", () => this.update());
    panel.on("writer", () => this.update());
    panel.on("link", () => this.update());
    if (panel.machine) this.refill();
    this.update();
  }

  /** The signals of the machine anew; what was chosen stays chosen where it is still there. */
  refill() {
    const before = this.signal.value, signals = this.signals().filter((s) => this.panel.columns.has(s.signal));
    const options = (list) => list.map((s) => make("option", { value: s.signal },
      s.label === s.signal ? s.signal : `${s.label} (${s.signal})`));
    const first = signals.filter((s) => s.first), rest = signals.filter((s) => !s.first);
    fill(this.signal, make("optgroup", { label: "shown in the plots" }, ...options(first)),
      make("optgroup", { label: "all others" }, ...options(rest)));
    const usual = signals.find((s) => s.role === "error") ?? signals[0];
    this.signal.value = signals.some((s) => s.signal === before) ? before : usual?.signal ?? "";
    this.relabel();
  }

  get chosen() { return this.signals().find((s) => s.signal === this.signal.value); }

  relabel() { this.level.shown.textContent = unit(this.chosen?.unit); }

  /** The trigger that is armed, for the line in the plot; level in the signal's own unit. */
  get trigger() { return this.panel.state?.scope?.trigger ?? null; }

  /** Shows the trigger that somebody armed, as long as nobody typed here. */
  adopt(trigger) {
    const text = JSON.stringify(trigger);
    if (this.touched || !trigger || text === this.adopted || !this.panel.columns.has(trigger.signal)) return;
    this.adopted = text;
    this.signal.value = trigger.signal;
    this.level.field.value = String(Number((trigger.level * (this.chosen?.factor ?? 1)).toPrecision(9)));
    [this.slope.value, this.mode.value] = [trigger.slope, trigger.mode];
    this.pre.field.value = String(Number((100 * trigger.pre).toPrecision(9)));
    this.length.field.value = String(trigger.length_s);
    this.relabel();
  }

  /** Arms as the form says, in another mode where one is given; gives null where it was refused. */
  async send(mode = this.mode.value) {
    const signal = this.chosen;
    for (const [part, name] of [[this.level, "Level"], [this.pre, "Before"], [this.length, "Length"]]) {
      const wrong = Number.isNaN(part.value);
      part.field.setAttribute("aria-invalid", String(wrong));
      const sentence = `${name}: "${part.field.value}" is no number; type one such as 0.05 or 2e-3.`;
      if (wrong) return this.complain(sentence, part.field);
    }
    if (!signal) return this.complain("Choose the signal to trigger on.", this.signal);
    this.wrong.textContent = "";
    return this.panel.tell("arm", {
      signal: signal.signal, level: this.level.value / signal.factor, slope: this.slope.value, mode,
      pre: this.pre.value / 100, length_s: this.length.value,
    });
  }

  /** A capture now, as long as the form says: a scope that waits for nothing is armed for one first. */
  async now() {
    const busy = ["armed", "taking"].includes(this.panel.state?.scope?.phase);
    if (busy || (await this.send("single"))) await this.panel.tell("force");
  }

  complain(text, field) {
    this.wrong.textContent = text;
    field.focus();
    return null;
  }

  update() {
    const { state, isWriter, connected } = this.panel, scope = state?.scope;
    this.adopt(scope?.trigger);
    const may = isWriter && connected !== false,
      why = may ? "" : "Only who has control can do this: take control first";
    for (const own of [this.arm, this.force]) Object.assign(own, { disabled: !may, title: why || own.title });
    this.disarm.disabled = !may || !["armed", "taking"].includes(scope?.phase);
    const text = words(scope, this.signals()) + (may ? "" : " You are watching: who has control arms the scope.");
    if (this.said.textContent !== text) this.said.textContent = text;
    this.said.dataset.phase = scope?.phase ?? "";
    const most = number(scope?.most_s ?? NaN, 3);
    this.length.field.title = `Length of the whole capture${most === "-" ? "" : `; up to ${most} s are kept`}`;
  }
}
