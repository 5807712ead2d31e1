/** Files: presets, saved captures, and the run as a script, as an experiment file and as a report. */

import { button, careful, fill, labelled, make } from "./elements.js";
import { bytes } from "./format.js";
import { NAME, download, savedOf } from "./saved.js";

const RULE = "A name has 1 to 64 letters, digits, blanks and _ . - and begins with a letter or digit.";
const RECORDS = [
  ["Script", "api/session.py", "A Python program that does all of this run again, value for value, without the panel."],
  ["Experiment file", "api/session.toml",
    "The same as data: what was started and every change with its period. leadscrew runs it again."],
  ["Report", "api/report.html", "One page to read and to print: what was done, the signals and the figures."],
];

/** Puts the Files part into an element of the page. */
export function mountFiles(element, panel) {
  element.classList.add("side");
  const said = make("p", { class: "side-note", role: "status" });
  fill(element, make("h2", {}, "Files"), presets(panel, said), records(panel, said), captures(panel, said), said);
}

function section(title, sentence, ...children) {
  return make("section", { class: "side-group", "aria-label": title }, make("h3", {}, title),
    make("p", { class: "side-soft" }, sentence), ...children);
}

/** Buttons that only who has control may use. */
function forWriter(panel, buttons, also = () => true) {
  const update = () => {
    const may = panel.isWriter && panel.connected !== false;
    for (const own of buttons) {
      own.disabled = !may || !also(own);
      own.title = may ? "" : "Only who has control can do this: take control first";
    }
  };
  for (const kind of ["writer", "link"]) panel.on(kind, update);
  update();
  return update;
}

function checked(field, said) {
  const name = field.value.trim(), good = NAME.test(name) && !name.includes("..");
  field.setAttribute("aria-invalid", String(!good));
  said.textContent = good ? "" : RULE;
  if (!good) field.focus();
  return good ? name : null;
}

function presets(panel, said) {
  const list = make("select", {}),
    name = make("input", { type: "text", maxLength: 64, autocomplete: "off", placeholder: "name" });
  const refresh = async (chosen = list.value) => {
    const names = (await panel.send("presets").catch(() => null))?.presets;
    if (!names) return;
    fill(list, ...(names.length ? names.map((n) => make("option", { value: n.name ?? n }, n.name ?? n))
      : [make("option", { value: "" }, "none saved yet")]));
    if (names.some((n) => (n.name ?? n) === chosen)) list.value = chosen;
    update();
  };
  const load = button("Load", async () => {
    const done = await panel.tell("preset_load", { name: list.value });
    if (done) said.textContent = `Preset ${list.value} is set; Undo takes it back.`;
  });
  const remove = careful("Delete", "Delete it?", async () => {
    const gone = list.value;
    if (await panel.tell("preset_delete", { name: gone })) said.textContent = `Preset ${gone} is deleted.`;
    refresh();
  });
  const store = async () => {
    const own = checked(name, said);
    if (!own || !(await panel.tell("preset_save", { name: own }))) return;
    said.textContent = `The values now are saved as preset ${own}.`;
    name.value = "";
    refresh(own);
  };
  const save = button("Save", store);
  const update = forWriter(panel, [load, remove, save], (own) => own === save || list.value !== "");
  panel.on("machine", () => refresh());
  panel.on("audit", ({ entry }) => entry.ok && /^preset_(save|delete)$/.test(entry.what) && refresh());
  if (panel.machine) refresh();
  return section("Presets", "All parameters under a name, to come back to.",
    make("div", { class: "side-line" }, labelled("Preset", list), load, remove),
    make("form", { class: "side-line", on: { submit: (e) => { e.preventDefault(); if (!save.disabled) store(); } } },
      labelled("Save the values now as", name), save));
}

/** Fetches a file of the run and says what became of it. */
async function fetched(panel, path, said) {
  said.textContent = "Being made ...";
  const done = await download(panel, path, path.split("/").at(-1));
  said.textContent = done ? `${done.name} (${bytes(done.bytes)}) is in the downloads.` : "";
}

function records(panel, said) {
  const lines = RECORDS.map(([title, path, sentence]) => {
    const link = make("a", { class: "side-link", href: path, download: "" }, title);
    link.addEventListener("click", (event) => {
      event.preventDefault();
      fetched(panel, path, said);
    });
    return make("li", {}, link, make("span", { class: "side-soft" }, sentence));
  });
  const name = make("input", { type: "text", maxLength: 64, autocomplete: "off", placeholder: "name" });
  const store = async () => {
    const own = checked(name, said), done = own && (await panel.tell("session_save", { name: own }));
    if (!done) return;
    said.textContent = `The run is kept beside the machine as ${done.name ?? own}.`;
    name.value = "";
  };
  const save = button("Save", store);
  forWriter(panel, [save]);
  const part = section("This run", "What was done, so that it can be done again.",
    make("ul", { class: "side-records" }, ...lines),
    make("form", { class: "side-line", on: { submit: (e) => { e.preventDefault(); if (!save.disabled) store(); } } },
      labelled("Keep it on the server as", name), save));
  // What a real machine did cannot be run again.
  panel.on("machine", (machine) => { part.hidden = !(machine.can.session ?? machine.simulated); });
  return part;
}

function captures(panel) {
  const saved = savedOf(panel), list = make("ul", { class: "side-files" });
  saved.watch((files) => fill(list, ...(files.length ? files.slice(0, 100).map((f) => make("li", {},
    make("a", { class: "side-link", href: saved.link(f.name), download: f.name,
      on: { click: (event) => saved.clicked(event, f.name) } }, f.name),
    make("span", { class: "side-soft" }, `${bytes(f.bytes)}, ${local(f.when)}`)))
      : [make("li", { class: "side-soft" }, "none saved yet")])));
  return section("Captures", "What the scope took and was saved; the Scope view lays them over each other.", list);
}

function local(when) {
  const date = new Date(when);
  return Number.isNaN(date.getTime()) ? String(when ?? "")
    : date.toLocaleString([], { dateStyle: "short", timeStyle: "short" });
}
