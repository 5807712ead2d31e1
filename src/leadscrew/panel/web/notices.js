// Sentences of the server that belong to no field: shown for a while in a line of their own below the page, where they
// hide nothing; all of them stand in the log.

import { button, make } from "./elements.js";

const MOST = 3;
const SHOWN_MS = { info: 6000, warning: 12000, error: 15000 };
const FRESH_MS = 2000; // what was said just before a run began may be about it

export function mountNotices(element, panel) {
  panel.on("notice", ({ level, text }) => show(element, level ?? "info", text));
  panel.on("fresh", () => {
    for (const old of [...element.children]) if (performance.now() - old.dataset.at > FRESH_MS) old.remove();
  });
}

function show(element, level, text) {
  for (const old of element.children) {
    if (old.dataset.text === text) old.remove(); // the same again: not two of them
  }
  const role = level === "error" ? "alert" : "status";
  const close = button("×", () => box.remove(), { "aria-label": "Close this message" });
  const box = make("div", { class: `notice ${level}`, role, data: { text, at: performance.now() } }, make("span", {}, text), close);
  element.append(box);
  while (element.children.length > MOST) element.firstChild.remove();
  setTimeout(() => box.remove(), SHOWN_MS[level] ?? SHOWN_MS.error);
}
