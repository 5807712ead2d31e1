/** Why the controller gives what it gives now: its rules, its sets, its phase plane, its circle. */

import { button, fill, make } from "./elements.js";
import { circleView } from "./why_circle.js";
import { phaseView } from "./why_phase.js";
import { rulesView } from "./why_rules.js";
import { setsView } from "./why_sets.js";
import { seen } from "./seen.js";

const KINDS = { circle: circleView, phase: phaseView, rules: rulesView, sets: setsView }; // in the order shown

function card(view) {
  const more = make("p", { class: "why-read" }, view.read);
  return make("section", { class: "side-card", "aria-label": view.title }, make("h3", {}, view.title), more,
    view.element);
}

/** A sentence where there is nothing to show. */
function noViews(machine) {
  const reason = machine.why_not_views;
  return reason
    || `${machine.controller} has no rules, no sliding surface and this is no circle run: its output is a formula of `
    + "the error, so there is nothing to explain here.";
}

/** Puts the Why view into an element of the page. */
export function mountWhy(element, panel) {
  element.classList.add("side", "why");
  const state = { views: new Map(), cards: new Map(), off: new Set(), visible: false, frozen: false, key: "",
    asked: "" };
  const title = make("p", { class: "why-title" }), cards = make("div", { class: "why-cards" });
  const shown = make("span", { class: "side-buttons", role: "group", "aria-label": "Pictures shown" });
  const freeze = button("Freeze", () => setFrozen(!state.frozen),
    { "aria-pressed": "false", title: "Keep the pictures as they are now; the machine runs on" });
  fill(element, make("div", { class: "side-bar" }, title, shown, freeze), cards);

  function setFrozen(frozen) {
    state.frozen = frozen;
    freeze.setAttribute("aria-pressed", String(frozen));
    freeze.textContent = frozen ? "Frozen: go on" : "Freeze";
    ask();
  }

  /** A button for each picture, that hides it or shows it again. */
  function chooser(name, view) {
    const own = button(view.name, () => {
      if (!state.off.delete(name)) state.off.add(name);
      update();
    });
    const update = () => {
      const on = !state.off.has(name);
      own.setAttribute("aria-pressed", String(on));
      state.cards.get(name).hidden = !on;
      ask();
    };
    queueMicrotask(update);
    return own;
  }

  function build() {
    const { machine } = panel;
    if (!machine) return;
    const names = Object.keys(KINDS).filter((name) => (machine.views ?? []).includes(name));
    const key = JSON.stringify([machine.run, machine.study, machine.controller, names]);
    title.textContent = machine.controller ?? "";
    freeze.hidden = names.length === 0;
    if (key !== state.key) {
      state.key = key;
      state.views = new Map(names.map((name) => [name, KINDS[name](panel)]));
      state.cards = new Map([...state.views].map(([name, view]) => [name, card(view)]));
      fill(cards, ...state.cards.values());
      fill(shown, ...(names.length > 1 ? [...state.views].map(([name, view]) => chooser(name, view)) : []));
      if (!names.length) fill(cards, make("p", { class: "why-none" }, noViews(machine)));
    }
    state.asked = "";
    ask();
  }

  function ask() {
    const views = state.visible && !state.frozen ? [...state.views.keys()].filter((name) => !state.off.has(name)) : [];
    const wish = JSON.stringify(views);
    if (wish === state.asked || (!state.asked && !views.length)) return;
    state.asked = wish;
    Promise.resolve(panel.send("why", { views })).catch(() => { state.asked = ""; });
  }

  panel.on("machine", build);
  panel.on("why", (message) => {
    if (state.frozen) return;
    for (const [name, data] of Object.entries(message.views ?? {})) if (data) state.views.get(name)?.show(data);
  });
  seen(element, (visible) => {
    state.visible = visible;
    ask();
  });
  build();
}
