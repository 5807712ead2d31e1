// The top row: what machine this is, what it runs, who has control, and whether the line to it stands.

const GROUPS = { paper: "as printed in the paper", corrected: "the paper's, corrected", ours: "ours" };

export function mountTop(element, panel) {
  const at = (id) => document.getElementById(id);
  const study = at("choose-study");
  const controller = at("choose-controller");
  const scenario = at("choose-scenario");
  const control = at("control");

  study.addEventListener("change", () => choose({ study: study.value }));
  scenario.addEventListener("change", () => choose(again({ scenario: scenario.value })));
  controller.addEventListener("change", async () => {
    const { machine, state } = panel;
    const fresh = !machine.can.switch || (state?.running === "stopped" && !state.t);
    if (fresh) await choose(again({ controller: controller.value }));
    else await panel.tell("switch", { controller: controller.value });
    fill();
  });
  control.addEventListener("click", () => panel.tell(panel.isWriter ? "release" : "take"));

  /** The machine as it is, but for what is given. */
  function again(what) {
    const { study: name, controller: by, scenario: from, seed, circle } = panel.machine;
    const noise = Number.isInteger(seed) ? { seed } : {};
    return { study: name, controller: by, scenario: from, ...noise, circle, ...what };
  }

  async function choose(what) {
    await panel.tell("machine", what);
    fill(); // refused: the lists show what runs
  }

  function fill() {
    const { machine } = panel;
    if (!machine) return;
    at("badge").textContent = machine.simulated ? "SIMULATED MACHINE: nothing moves" : machine.title;
    at("badge").classList.toggle("real", !machine.simulated);
    at("badge").title = machine.notice ?? "";
    document.title = `${machine.study} ${machine.controller} - Leadscrew panel`;
    list(study, machine.studies, machine.study, (x) => (x.title && x.title !== x.name ? `${x.title} (${x.name})` : x.name));
    list(scenario, machine.scenarios, machine.scenario, (x) => x.name, (x) => x.doc);
    controllers(controller, machine);
    for (const select of [study, scenario, controller]) select.parentElement.hidden = !select.options.length;
    sentence(at("sentence"), machine);
    at("caution").hidden = machine.simulated; // of a real machine: all of it, always
    at("caution").textContent = machine.simulated ? "" : machine.notice;
    allow();
  }

  function allow() {
    const { state, isWriter, connected, machine } = panel;
    const may = connected && isWriter && machine?.simulated !== false;
    const moving = state?.running === "running" || state?.running === "building";
    study.disabled = !may || moving;
    scenario.disabled = !may || moving;
    controller.disabled = !may || state?.running === "building" || (moving && !machine?.can?.switch);
    for (const select of [study, scenario, controller]) { // lists are narrower than what they say
      const chosen = select.selectedOptions[0];
      const whole = [chosen?.text, chosen?.title].filter(Boolean).join("\n");
      select.title = select !== controller && moving && may ? `${whole}\nStop or hold the machine first.` : whole;
    }
    control.disabled = !connected;
  }

  function writer() {
    const { isWriter } = panel;
    at("writer").textContent = saysWriter(panel);
    at("link-text").textContent = linkWords(panel);
    at("writer").title = isWriter ? `As ${panel.name}` : "One page has control, the others watch";
    control.textContent = isWriter ? "Release control" : "Take control";
    element.dataset.writer = String(isWriter);
    allow();
  }

  panel.on("machine", () => { fill(); writer(); });
  panel.on("state", writer);
  panel.on("writer", writer);
  panel.on("link", (link) => { showLink(link); writer(); });
}

function linkWords({ connected, state }) {
  if (!connected) return state ? "no connection" : "connecting";
  return state?.watchers ? `connected, ${state.watchers} watching` : "connected";
}

function saysWriter({ isWriter, connected, state }) {
  if (isWriter) return connected ? "You have control" : "Control is kept for you";
  const other = state?.writer;
  if (!other) return "Nobody has control";
  return other.id === 0 ? `${other.name} has control, but is away` : `You watch; ${other.name} has control`;
}

function list(select, items, chosen, words, title) {
  const of = JSON.stringify(items);
  if (select.dataset.of !== of) {
    select.dataset.of = of;
    select.replaceChildren(...items.map((item) => {
      const option = new Option(words(item), item.name);
      if (title) option.title = title(item) ?? "";
      return option;
    }));
  }
  if (select.value !== chosen) select.value = chosen;
}

/** Controllers below whose they are; those that take over with a bump of the output say so. */
function controllers(select, machine) {
  const of = JSON.stringify(machine.controllers);
  if (select.dataset.of !== of) {
    select.dataset.of = of;
    const groups = new Map();
    for (const item of machine.controllers) {
      const head = item.name.split(".")[0];
      if (!groups.has(head)) {
        const group = document.createElement("optgroup");
        group.label = GROUPS[head] ? `${head}: ${GROUPS[head]}` : head;
        groups.set(head, group);
      }
      const bumps = item.bumpless === false;
      const option = new Option(bumps ? `! ${item.name}` : item.name, item.name);
      if (bumps) option.title = "! takes over with a bump of the output";
      groups.get(head).append(option);
    }
    select.replaceChildren(...groups.values());
  }
  if (select.value !== machine.controller) select.value = machine.controller;
}

function sentence(element, machine) {
  const scenario = machine.scenarios.find((item) => item.name === machine.scenario);
  element.textContent = machine.simulated ? scenario?.doc || machine.title : "";
  element.title = [machine.title, machine.paper, scenario?.doc].filter(Boolean).join("\n");
}

function showLink({ link, text }) {
  document.body.dataset.connected = link === "open" ? "yes" : "no";
  const banner = document.getElementById("banner");
  banner.hidden = link === "open" || link === "connecting";
  banner.textContent = link === "refused"
    ? `The panel refused this page: ${text}`
    : `Connection lost${text && text !== "connection lost" ? ` (${text})` : ""}. The machine runs on; nothing here can reach it. Trying again by itself.`;
}
