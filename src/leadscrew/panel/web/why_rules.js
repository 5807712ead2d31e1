/** The rules that fire now: one bar for each, as long as its share of the controller's output. */

import { fill, make } from "./elements.js";
import { number, withUnit } from "./format.js";

export const READ =
  "Each line is one rule of the controller. The bar shows how much of the output comes from that rule now; " +
  "the strength says how well the rule's condition is met (0 not at all, 1 fully).";

function gauge() {
  const name = make("b"), value = make("span", { class: "why-value" }), mark = make("i");
  const low = make("span"), high = make("span");
  const bar = make("span", { class: "why-gauge", "aria-hidden": "true" }, mark);
  const element = make("div", { class: "why-input" }, name, value, low, bar, high);
  return {
    element,
    show(input) {
      name.textContent = input.name;
      value.textContent = withUnit(input.value, input.unit);
      const ranged = Number.isFinite(input.low) && Number.isFinite(input.high) && input.high > input.low;
      element.classList.toggle("why-plain", !ranged);
      if (!ranged) return;
      low.textContent = number(input.low, 3);
      high.textContent = number(input.high, 3);
      const share = (input.value - input.low) / (input.high - input.low);
      mark.style.left = `${100 * Math.min(1, Math.max(0, share))}%`;
      mark.classList.toggle("why-beyond", share < 0 || share > 1);
    },
  };
}

function row() {
  const place = make("span", { class: "why-number" }), text = make("span", { class: "why-text" });
  const bar = make("i"), share = make("span", { class: "why-share" }),
    strength = make("span", { class: "why-strength" });
  const track = make("span", { class: "why-bar", "aria-hidden": "true" }, bar);
  const element = make("li", {}, place, text, track, share, strength);
  return {
    element,
    show(rule) {
      place.textContent = rule.number;
      text.textContent = rule.text;
      text.title = rule.text;
      bar.style.width = `${100 * Math.min(1, Math.max(0, rule.share))}%`;
      share.textContent = `${(100 * rule.share).toFixed(rule.share >= 0.0995 ? 0 : 1)} %`;
      strength.textContent = rule.strength === null ? "" : rule.strength.toFixed(2);
    },
  };
}

/** As many parts as there are data; parts are kept and reused, so that ten pictures a second cost little. */
function adapt(list, parts, kind, data) {
  while (parts.length < data.length) {
    parts.push(kind());
    list.append(parts.at(-1).element);
  }
  parts.forEach((part, i) => {
    part.element.hidden = i >= data.length;
    if (i < data.length) part.show(data[i]);
  });
}

/** The view of the rules. */
export function rulesView() {
  const inputs = make("div", { class: "why-inputs" }), outputs = make("p", { class: "why-note" });
  const list = make("ol", { class: "why-rules" }), count = make("p", { class: "why-note" });
  const head = make("div", { class: "why-head", "aria-hidden": "true" },
    ...["no.", "rule", "share of the output", "", "strength"].map((t) => make("span", {}, t)));
  const [ins, rows] = [[], []];
  return {
    name: "Rules",
    title: "Rules that fire",
    read: READ,
    element: make("div", {}, inputs, outputs, head, list, count),
    show(data) {
      adapt(inputs, ins, gauge, data.inputs ?? []);
      outputs.textContent = (data.outputs ?? []).map((o) => `${o.name} = ${withUnit(o.value, o.unit)}`).join(",  ");
      adapt(list, rows, row, data.rules ?? []);
      const firing = data.rules?.length ?? 0;
      fill(count, firing
        ? `${firing} of ${data.total} rules shown, the strongest first${data.note ? `; ${data.note}` : ""}.`
        : `None of the ${data.total} rules fires.`);
    },
  };
}
