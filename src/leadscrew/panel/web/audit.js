/** Who changed what when, from which value to which; refused tries too. The newest first, the last 500 held. */

import { fill, make } from "./elements.js";
import { plain, timeOfDay } from "./format.js";

const HELD = 500;
const SHOWN = 150;

/** Puts the audit part into an element of the page. */
export function mountAudit(element, panel) {
  element.classList.add("side");
  const find = make("input",
    { type: "search", placeholder: "filter: name, key, refused", "aria-label": "Filter the log" });
  const refused = make("input", { type: "checkbox", "aria-label": "Only refused tries" });
  const list = make("ol",
    { class: "audit-list", tabIndex: 0, "aria-label": "Log, the newest first", "aria-live": "off" });
  const count = make("p", { class: "side-soft" });
  let entries = [], asked = false;
  const draw = () => {
    asked = false;
    const found = matching(entries, find.value, refused.checked);
    fill(list, ...found.slice(0, SHOWN).map(line));
    count.textContent = entries.length ? `${Math.min(found.length, SHOWN)} of ${entries.length} entries.`
      : "Nothing was changed yet.";
  };
  const redraw = () => {
    if (asked) return;
    asked = true;
    setTimeout(draw, 100); // a storm of tries must not slow the page
  };
  const refresh = async () => {
    const known = (await panel.send("audit", { last: HELD }).catch(() => null))?.entries;
    if (!known) return;
    entries = newestFirst(known).slice(0, HELD);
    redraw();
  };
  panel.on("audit", ({ entry }) => {
    entries = [entry, ...entries].slice(0, HELD);
    redraw();
  });
  panel.on("link", ({ link }) => link === "open" && refresh());
  find.addEventListener("input", redraw);
  refused.addEventListener("change", redraw);
  fill(element, make("h2", {}, "Log"),
    make("p", { class: "side-soft" }, "Who changed what and when, with the value before and after."),
    make("div", { class: "side-line" }, find, make("label", { class: "side-check" }, refused, "refused only")),
    list, count);
  draw();
  if (panel.connected) refresh();
}

/** Entries by time, the newest first, whichever way they came. */
export function newestFirst(entries) {
  const forward = entries.length > 1 && String(entries[0].at) <= String(entries.at(-1).at);
  return forward ? [...entries].reverse() : [...entries];
}

/** Those that hold every word that was typed. */
export function matching(entries, text, refusedOnly = false) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return entries.filter((e) => {
    if (refusedOnly && e.ok) return false;
    const held = [e.who, e.what, e.key, plain(e.old), plain(e.new), e.error, e.ok ? "done" : "refused"];
    const joined = held.join(" ").toLowerCase();
    return words.every((w) => joined.includes(w));
  });
}

function line(entry) {
  const when = Number.isFinite(entry.t) ? `t = ${Number(entry.t).toFixed(2)} s` : "";
  const head = make("div", { class: "audit-head" }, make("time", { title: `${entry.at}, ${when}` }, timeOfDay(entry.at)),
    make("b", {}, entry.who || "the panel"), make("span", {}, entry.what),
      !entry.ok && make("strong", { class: "audit-refused" }, "refused"));
  const before = plain(entry.old), after = plain(entry.new);
  const change = entry.key || before || after
    ? make("div", { class: "audit-change" }, entry.key ? make("code", {}, entry.key) : "",
    before || after ? make("span", {}, before && after ? `${before} → ${after}` : after || before) : null) : null;
  return make("li", { class: entry.ok ? "" : "audit-no" }, head, change,
    !entry.ok && entry.error && make("div", { class: "audit-why" }, entry.error));
}
