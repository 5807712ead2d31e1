/** The captures saved beside the machine: listed, loaded, uploaded, downloaded; one list for all parts of the page. */

/** Of presets, captures and sessions, as the server allows them. */
export const NAME = /^[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}$/;
const MOST_BYTES = 50e6;
const stores = new WeakMap();

/** The list of a panel. */
export function savedOf(panel) {
  if (!stores.has(panel)) stores.set(panel, new Saved(panel));
  return stores.get(panel);
}

/** Fetches a file of the server and hands it to the browser; gives its name and size, or null with a notice why not. */
export async function download(panel, path, name) {
  try {
    const answer = await fetch(path);
    if (!answer.ok) throw new Error(`${name}: ${await refusal(answer)}`);
    const given = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1] ?? name;
    const blob = await answer.blob();
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: given });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    return { name: given, bytes: blob.size };
  } catch (problem) {
    panel.emit("notice", { kind: "notice", level: "error", text: problem.message });
    return null;
  }
}

/** A file name as the server keeps one: other letters without their marks, all else as a line. */
export function kept(name) {
  const plain = name.normalize("NFKD").replace(/[\u0300-\u036f]/g, "").replace(/[^A-Za-z0-9 _.-]/g, "_")
    .replace(/\.{2,}/g, ".");
  const suffix = /\.[A-Za-z0-9]{1,8}$/.exec(plain)?.[0] ?? "";
  const stem = plain.slice(0, plain.length - suffix.length).replace(/^[^A-Za-z0-9]+/, "");
  return (stem.slice(0, 64 - suffix.length).trim() || "log") + suffix;
}

/** The sentence of an answer that is no success. */
export async function refusal(answer) {
  const text = (await answer.text().catch(() => "")).trim();
  try {
    return JSON.parse(text).error ?? text;
  } catch {
    return text && text.length < 400 ? text : `the server refused it (${answer.status})`;
  }
}

class Saved {
  constructor(panel) {
    this.panel = panel;
    this.files = []; // {name, bytes, when}, the newest first
    this.hearers = new Set();
    this.loads = 0; // loads asked for and not yet answered
    panel.on("machine", () => this.refresh());
    panel.on("audit", ({ entry }) => {
      if (entry.ok && /^capture_(save|receive)$/.test(entry.what)) this.refresh();
    });
    if (panel.machine) this.refresh();
  }

  /** Calls `hear(files)` now and whenever the list is another. */
  watch(hear) {
    this.hearers.add(hear);
    hear(this.files);
  }

  async refresh() {
    try {
      this.files = (await this.panel.send("captures")).captures ?? [];
    } catch {
      return; // asked again with the next machine message
    }
    for (const hear of this.hearers) hear(this.files);
  }

  /** Reads a saved capture in; gives its number, or null where it was refused (and said so). */
  async load(name) {
    this.loads += 1;
    try {
      return (await this.panel.tell("capture_load", { name }))?.capture ?? null;
    } finally {
      this.loads -= 1;
    }
  }

  async save(name, format, which) {
    const result = await this.panel.tell("capture_save", { name, format, which });
    if (result) this.refresh();
    return result;
  }

  /** Sends a file of this computer and reads it in; gives the number of its capture, or null. */
  async upload(file) {
    const say = (text) => this.panel.emit("notice", { kind: "notice", level: "error", text });
    if (file.size > MOST_BYTES) {
      say(`${file.name} has ${(file.size / 1e6).toFixed(0)} MB; up to 50 MB are taken: cut it into parts.`);
      return null;
    }
    const name = kept(file.name);
    try {
      const answer = await fetch(`api/captures/${encodeURIComponent(name)}`,
        { method: "POST", body: file, headers: { "Leadscrew-Secret": this.panel.secret } });
      if (!answer.ok) throw new Error(`${file.name} could not be taken: ${await refusal(answer)}`);
      await this.refresh();
      return await this.load(name);
    } catch (problem) {
      say(problem.message);
      return null;
    }
  }

  /** Where a saved capture lies on the server. */
  link(name) {
    return `api/captures/${encodeURIComponent(name)}`;
  }

  /** A click on a link to a saved capture: fetched, so that a refusal is a notice and no other page. */
  clicked(event, name) {
    event.preventDefault();
    return download(this.panel, this.link(name), name);
  }
}
