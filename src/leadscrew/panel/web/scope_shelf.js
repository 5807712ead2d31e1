/** The captures on the screen and on the disk: which are drawn, moved in time, saved, loaded, uploaded, downloaded. */

import { button, choice, fill, labelled, make } from "./elements.js";
import { bytes, duration, timeOfDay, typed } from "./format.js";
import { NAME, savedOf } from "./saved.js";
import { lineKey } from "./scope_key.js";

const FORMATS = [["parquet", "Parquet"], ["csv", "CSV"], ["mat", "MAT"]];

/** A name that no other capture has: the machine and the time of day. */
function proposal(panel) {
  const now = new Date(), two = (n) => String(n).padStart(2, "0");
  const time = [now.getHours(), now.getMinutes(), now.getSeconds()].map(two).join(".");
  return `${panel.machine?.study ?? "capture"} ${time}`;
}

export class Shelf {
  /**
   * @param {HTMLElement} element @param {object} panel @param {import("./scope_entries.js").Entries} entries
   * @param {{lay: (id: number, name: string) => void, changed: () => void}} acts
   */
  constructor(element, panel, entries, acts) {
    Object.assign(this, { panel, entries, acts, saved: savedOf(panel) });
    this.list = make("ul", { class: "scope-captures", "aria-label": "Captures on the screen" });
    this.said = make("p", { class: "side-note", role: "status" });
    fill(element, this.list, this.saving(), this.loading(), this.said);
    this.saved.watch((files) => this.files(files));
    for (const kind of ["writer", "link"]) panel.on(kind, () => this.allow());
    this.show();
  }

  saving() {
    this.name = make("input", { type: "text", maxLength: 64, size: 24, autocomplete: "off" });
    this.format = choice(FORMATS, "parquet");
    this.save = button("Save capture", () => this.store());
    const form = { class: "side-line", on: { submit: (e) => { e.preventDefault(); this.store(); } } };
    return make("form", form, labelled("Save as", this.name), labelled("Format", this.format), this.save);
  }

  loading() {
    this.choose = make("select", {});
    this.load = button("Overlay", () => this.read());
    this.download = make("a", { class: "side-link", download: "" }, "Download");
    this.download.addEventListener("click", (event) => this.saved.clicked(event, this.choose.value));
    this.choose.addEventListener("change", () => this.linked());
    const file = make("input", {
      type: "file", class: "side-hidden", tabIndex: -1, accept: ".parquet,.csv,.mat,.pq,.txt,.tsv,.log,.dat",
      "aria-label": "File to overlay",
    });
    file.addEventListener("change", async () => {
      const [own] = file.files;
      if (own) await this.laid(this.saved.upload(own), own.name);
      file.value = "";
    });
    this.upload = button("Upload a file", () => file.click());
    return make("div", { class: "side-line" }, labelled("Saved captures", this.choose), this.load, this.download,
      this.upload, file);
  }

  files(list) {
    const before = this.choose.value;
    fill(this.choose, ...list.map((f) => make("option", { value: f.name }, `${f.name} (${bytes(f.bytes)})`)));
    if (list.some((f) => f.name === before)) this.choose.value = before;
    if (!list.length) fill(this.choose, make("option", { value: "" }, "none saved yet"));
    this.linked();
  }

  linked() {
    const name = this.choose.value;
    this.allow();
    this.download.hidden = !name;
    if (name) this.download.href = this.saved.link(name);
  }

  async store() {
    const name = this.name.value.trim() || proposal(this.panel), { main } = this.entries;
    if (!main || this.save.disabled) return;
    if (!NAME.test(name) || name.includes("..")) {
      this.said.textContent = "A name has 1 to 64 letters, digits, blanks and _ . - and begins with a letter or digit.";
      this.name.focus();
      return;
    }
    this.said.textContent = `Saving ${name} ...`;
    const done = await this.saved.save(name, this.format.value, main.id);
    this.said.textContent = done ? `Saved as ${done.name} (${bytes(done.bytes)}).` : "";
    if (done) this.name.value = "";
  }

  read() {
    return this.laid(this.saved.load(this.choose.value), this.choose.value);
  }

  async laid(loading, name) {
    this.said.textContent = `Loading ${name} ...`;
    const id = await loading;
    this.said.textContent = "";
    if (id !== null) this.acts.lay(id, name.replace(/\.[a-z]+$/, ""));
  }

  /** Says what became of a capture that was laid over. */
  say(text) {
    this.said.textContent = text;
  }

  /** The list of what is drawn. */
  show() {
    const { main, overlays } = this.entries;
    this.name.placeholder = proposal(this.panel);
    this.allow();
    fill(this.list, main && this.line(main, true), ...overlays.map((e) => this.line(e, false)));
  }

  /** Only who has control saves, loads and uploads; everybody downloads. */
  allow() {
    const may = this.panel.isWriter && this.panel.connected !== false;
    for (const [own, able, title] of [
      [this.save, this.entries.main, "Keep the capture beside the machine"],
      [this.load, this.choose.value, "Load the saved capture and lay it over what is drawn"],
      [this.upload, true, "A capture or log of this computer: Parquet, CSV, MAT, text; up to 50 MB"],
    ]) {
      own.disabled = !may || !able;
      own.title = may ? title : "Only who has control can do this: take control first";
    }
  }

  line(entry, isMain) {
    const { capture } = entry, key = lineKey("#4d565f", entry.dash);
    const visible = make("input", { type: "checkbox", checked: entry.visible, "aria-label": `Draw ${entry.name}` });
    visible.addEventListener("change", () => { entry.visible = visible.checked; this.acts.changed(); });
    const shift = make("input",
      { type: "text", inputMode: "decimal", size: 7, value: String(Number((1000 * entry.shift).toPrecision(9))) });
    shift.addEventListener("change", () => {
      const ms = typed(shift.value);
      shift.setAttribute("aria-invalid", String(Number.isNaN(ms)));
      if (Number.isNaN(ms)) return;
      entry.shift = ms / 1000;
      this.acts.changed();
    });
    const about = capture.about ?? {};
    const words = [`${capture.rows} rows`, `every ${duration(capture.period_s)}`, about.controller,
      timeOfDay(about.when)].filter(Boolean).join(", ");
    const remove = button("Remove", () => { this.entries.remove(entry); this.acts.changed(); }, {
      "aria-label": `Remove ${entry.name} from the screen`,
    });
    const keep = isMain && button("Keep as overlay", () => { this.entries.keep(); this.acts.changed(); }, {
      title: "Stays on the screen, dashed, when the next capture is taken",
      disabled: this.entries.overlays.some((e) => e.id === entry.id),
    });
    return make("li", {}, visible, key, make("b", {}, entry.name), make("span", { class: "side-soft" }, words),
      !isMain && labelled("shift", shift, "ms"), keep, remove);
  }
}
