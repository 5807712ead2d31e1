// The page: one object `panel` that every part of it uses, and the parts mounted into the elements of index.html.

import { Connection } from "./connection.js";
import { History } from "./history.js";
import { mountControls } from "./controls.js";
import { mountDisturb } from "./disturb.js";
import { mountCompare } from "./compare.js";
import { mountKeyboard } from "./keyboard.js";
import { mountOptions } from "./options.js";
import { mountParameters } from "./parameters.js";
import { mountPlots } from "./plots.js";
import { mountTabs } from "./tabs.js";
import { mountTop } from "./top.js";
import { mountNotices } from "./notices.js";
import { ownSecret } from "./secret.js";
import { mountRefused } from "./refused.js";
import { Latency } from "./timing.js";

const OTHERS = [
  ["scope.js", "mountScope", "view-scope"], ["why.js", "mountWhy", "view-why"],
  ["files.js", "mountFiles", "part-files"], ["audit.js", "mountAudit", "part-audit"],
];

function remembered(store, key, make) {
  try {
    const found = store.getItem(key) ?? make();
    store.setItem(key, found);
    return found;
  } catch {
    return make(); // a browser that keeps nothing
  }
}

const listeners = new Map();

export const panel = {
  machine: null, // the last message "machine"
  state: null, // the last message "state"
  columns: new Map(), // name -> number of the column in frames and histories
  history: new History([], 1024), // rows of the machine
  ghostHistory: new History([], 1024), // rows of the previous setting
  captures: new Map(), // id -> message "capture" with values: Float64Array, row-major
  isWriter: false,
  connected: false,
  you: null, // number of this client
  name: remembered(localStorage, "leadscrew.name", () => `Operator ${10 + Math.floor(Math.random() * 90)}`),
  secret: null, // of this page, known before its first message; it gives control back after a lost connection
  view: "live", // the tab shown
  measures: { fps: 0, latency_ms: [] },

  /** Asks the machine; gives the result, or throws an Error with the server's sentence (and `key` where it has one). */
  async send(what, args = {}) {
    const sent = performance.now();
    const result = await connection.ask(what, args);
    if (Number.isFinite(result?.period) && Latency.counts(what)) latency.expect(sent, result.period);
    return result;
  },

  /** As send; a refusal is shown as a notice, and the answer is then null. */
  async tell(what, args = {}) {
    try {
      return await panel.send(what, args);
    } catch (error) {
      panel.emit("notice", { kind: "notice", level: "error", text: error.message });
      return null;
    }
  },

  /**
   * Calls `heard(message)` for every: machine, state, audit, why, capture, notice (from the server), and of the page:
   * "fresh" number of the run whose first rows come now (the histories are new objects), "link" {link, text},
   * "writer" boolean, "view" name of the tab, "rows" {kind, first, stride, rows} after they are in the histories,
   * "drawn" {now, last} after the plots were drawn with rows up to the period `last`.
   * Gives a function that ends it.
   */
  on(kind, heard) {
    if (!listeners.has(kind)) listeners.set(kind, new Set());
    listeners.get(kind).add(heard);
    return () => listeners.get(kind).delete(heard);
  },

  emit(kind, message) {
    for (const heard of listeners.get(kind) ?? []) {
      try {
        heard(message);
      } catch (error) {
        console.error(`panel: ${kind}`, error); // one part that fails must not take Stop away
      }
    }
  },

  hello: () => connection.again(), // the line anew, with another name
  drop: () => connection.socket?.close(), // as if the line was lost, for tests
};

const latency = new Latency(panel);
panel.on("drawn", ({ last }) => latency.drawn(last));

/** The histories hold the rows of one run; those of the last one stay to be looked at until the next one moves. */
let historyRun = null;

function onMachine(message) {
  const names = message.columns.map((column) => column.name);
  const another = panel.machine?.study !== message.study;
  const sameRun = historyRun === message.run;
  const sameColumns = panel.history.names.join() === names.join();
  panel.machine = message;
  panel.columns = new Map(names.map((name, number) => [name, number]));
  if (another || (!sameRun && !sameColumns)) renew(message.run);
  else if (!sameColumns) {
    panel.history.keep(names);
    panel.ghostHistory.keep(names);
  }
}

function renew(run) {
  historyRun = run;
  const names = [...panel.columns.keys()];
  panel.history = new History(names);
  panel.ghostHistory = new History(names);
  latency.clear();
}

let captureToCome = null;

function onText(message) {
  if (message.kind === "machine") onMachine(message);
  else if (message.kind === "state") {
    panel.state = message;
    setWriter(Boolean(message.writer) && message.writer.id === panel.you);
  } else if (message.kind === "capture") {
    captureToCome = message.capture; // its rows follow
    return;
  }
  panel.emit(message.kind, message);
  takeAtFirst();
}

let decided = false;

/** The first page of a simulated machine has control without asking; of a real one, nobody has it unasked. */
function takeAtFirst() {
  if (decided || !panel.machine || !panel.state) return;
  decided = true;
  if (panel.machine.simulated && !panel.state.writer) panel.tell("take");
}

function onFrame(frame) {
  if (frame.kind === 3) {
    if (!captureToCome || captureToCome.id !== frame.run) return;
    const capture = { ...captureToCome, rows: frame.rows, values: frame.values };
    captureToCome = null;
    panel.captures.set(capture.id, capture);
    panel.emit("capture", { kind: "capture", capture });
    return;
  }
  if (!panel.machine || frame.run !== panel.machine.run || frame.columns !== panel.history.names.length) return;
  if (historyRun !== frame.run) {
    renew(frame.run);
    panel.emit("fresh", frame.run);
  }
  const history = frame.kind === 2 ? panel.ghostHistory : panel.history;
  if (history.push(frame.first, frame.stride, frame.rows, frame.values)) panel.emit("rows", frame);
}

function setWriter(is) {
  if (panel.isWriter === is) return;
  panel.isWriter = is;
  panel.emit("writer", is);
}

const scheme = location.protocol === "https:" ? "wss:" : "ws:";
const connection = new Connection(`${scheme}//${location.host}/ws`, {
  hello: () => ({
    name: panel.name, secret: panel.secret,
    since: panel.history.serial && historyRun === panel.machine?.run ? panel.history.last + 1 : null,
  }),
  onHello: (result) => {
    panel.you = result.you;
    setWriter(Boolean(result.writer));
  },
  shut: async () => {
    const answer = await fetch("./", { cache: "no-store" }).catch(() => null);
    return answer?.status === 401 ? answer.text() : "";
  },
  onRefused: (error) => panel.emit("link", { link: "refused", text: error.message }),
  onText,
  onFrame,
  onLink: (link, text) => {
    panel.connected = link === "open";
    panel.emit("link", { link, text });
  },
});

const at = (id) => document.getElementById(id);
mountTop(at("top"), panel);
mountControls(at("row-run"), panel);
mountParameters(at("left"), panel);
mountTabs(at("tabs"), panel);
mountPlots(at("view-live"), panel);
mountCompare(at("part-compare"), panel);
mountDisturb(at("part-disturb"), panel);
mountNotices(at("notices"), panel);
mountKeyboard(at("keys"), panel);
mountOptions(at("run-options"), panel);
mountRefused(at("refused"), panel);
for (const [file, mount, id] of OTHERS) {
  import(`./${file}`).then((part) => part[mount](at(id), panel)).catch((error) => {
    console.error(`panel: ${file}`, error);
    at(id).textContent = `This part could not be shown (${file}: ${error.message}).`;
  });
}

window.panel = panel; // for tests and for people at the console
ownSecret().then((own) => {
  panel.secret = own;
  connection.open();
});
