// Start, hold, stop, reset, speed; state and time of the machine.

import { put } from "./elements.js";
import { clock } from "./format.js";

const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const WORDS = {
  stopped: "STOPPED", running: "RUNNING", held: "HELD", diverged: "DIVERGED", building: "BUILDING ...",
};

function speedWords(speed) {
  if (speed === 1) return "real time";
  return speed < 1 ? `slow × ${speed}` : `fast × ${speed}`;
}

export function mountControls(element, panel) {
  const at = (id) => document.getElementById(id);
  const buttons = { start: at("start"), hold: at("hold"), stop: at("stop"), reset: at("reset") };
  const speed = at("speed");
  speed.replaceChildren(...SPEEDS.map((value) => new Option(speedWords(value), value)));
  for (const [what, button] of Object.entries(buttons)) button.addEventListener("click", () => panel.tell(what));
  speed.addEventListener("change", async () => {
    await panel.tell("speed", { value: Number(speed.value) });
    show(); // refused: put back
  });

  const show = () => {
    const { state, machine } = panel;
    allow(panel, buttons, speed);
    if (!state) return;
    document.body.dataset.running = panel.connected ? state.running : "unknown";
    put(at("running"), panel.connected ? WORDS[state.running] ?? state.running : "NOT CONNECTED");
    showTime(panel, at("time"));
    put(at("message"), inWords(state.message ?? "", machine));
    if (document.activeElement !== speed) pick(speed, state.speed);
    const short = shortcoming(state);
    at("behind").hidden = !short;
    put(at("behind"), short);
    put(buttons.hold.firstChild, machine?.simulated === false ? "Hold display " : "Hold "); // a real one goes on
    put(buttons.start.firstChild, state.running === "held" ? "Go on " : "Start ");
    buttons.reset.title = machine ? "Back to the start of the scenario, with the parameters as they are now" : "";
  };
  for (const kind of ["state", "machine", "link", "writer"]) panel.on(kind, show);
  panel.on("rows", () => { moved = true; });
  let moved = false;
  setInterval(() => {
    if (moved) showTime(panel, at("time"));
    moved = false;
  }, 100);
}

/** A sentence of the machine with the label of the plots beside the name of a signal. */
function inWords(text, machine) {
  const trace = machine?.plots.flatMap((plot) => plot.traces).find(({ signal }) => text.includes(`: ${signal} is `));
  return trace ? text.replace(`: ${trace.signal} is `, `: ${trace.label} (${trace.signal}) is `) : text;
}

/** What the display lacks: time that was not kept, rows that were not sampled. */
function shortcoming({ behind, lost }) {
  if (behind) return "behind: slower than chosen";
  return lost ? `${lost} ${lost === 1 ? "period" : "periods"} lost: gaps in the traces` : "";
}

function showTime(panel, element) {
  const { state, machine, history } = panel;
  const told = state?.t ?? 0;
  const seen = history.serial && machine ? (history.last + 1) * machine.period_s : 0;
  put(element, clock(state?.running === "running" ? Math.max(told, seen) : told));
}

function allow(panel, buttons, speed) {
  const { state, machine, isWriter, connected } = panel;
  const may = Boolean(connected && state && machine && isWriter);
  const can = machine?.can ?? {};
  const running = state?.running;
  const busy = running === "building";
  buttons.start.disabled = !may || !can.start || busy || running === "running" || running === "diverged";
  buttons.hold.disabled = !may || !can.hold || running !== "running";
  buttons.stop.disabled = !may || !can.stop || busy || running === "stopped";
  buttons.reset.disabled = !may || !can.reset || busy;
  speed.disabled = !may || !can.speed;
  for (const [what, control] of [...Object.entries(buttons), ["speed", speed.parentElement]]) {
    control.hidden = Boolean(machine) && !can[what]; // a real machine is not started or stopped from here
  }
  const taken = isWriter ? "" : "Take control first: another page may be running the machine.";
  const why = connected ? taken : "Not connected.";
  for (const control of [...Object.values(buttons), speed]) control.title = why;
}

/** Chooses a value in a list, added to it where it is not there. */
function pick(select, value) {
  if (![...select.options].some((option) => Number(option.value) === value)) {
    select.append(new Option(speedWords(value), value));
  }
  if (Number(select.value) !== value) select.value = String(value);
}
