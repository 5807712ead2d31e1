// Keys: Esc always stops; the others act only where nothing is being typed.

const KEYS = [
  ["Esc", "Stop the machine, at any time"], ["S", "Start"], ["H", "Hold; S goes on"],
  ["Shift+R", "Reset to the start of the scenario"],
  ["Ctrl+Z", "Undo the last change of parameters"], ["Ctrl+Shift+Z or Ctrl+Y", "Redo"],
  ["P", "Pause the display; the machine runs on"], ["/", "Search the parameters"], ["1, 2, 3", "Live, Scope, Why"],
  ["?", "This list"],
];

/** Whether keys typed now belong to a field. */
function isTyping(target) {
  if (!(target instanceof Element)) return false;
  if (target.isContentEditable || target.matches("textarea, select")) return true;
  return target.matches("input") && !["checkbox", "radio", "button", "submit", "range", "file"].includes(target.type);
}

export function mountKeyboard(dialog, panel) {
  fill(dialog);
  const help = () => {
    about(dialog.querySelector("#about"), panel.machine);
    if (dialog.open) dialog.close();
    else dialog.showModal();
  };
  document.getElementById("help").addEventListener("click", help);
  const press = (id) => {
    const button = document.getElementById(id);
    if (button && !button.disabled) button.click();
  };
  const plain = {
    s: () => press("start"), h: () => press("hold"), p: () => press("pause"), "?": help,
    1: () => panel.show("live"), 2: () => panel.show("scope"), 3: () => panel.show("why"),
    "/": () => document.getElementById("search")?.focus(),
  };
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      press("stop"); // whatever has the focus
      watching(panel);
      return;
    }
    if (event.repeat || isTyping(event.target) || document.querySelector("dialog[open]")) return;
    const act = actOf(event, plain, press);
    if (!act) return;
    event.preventDefault();
    act();
  }, true);
}

/** Where Esc cannot stop the machine, that must not look as if it had. */
function watching({ state, machine, isWriter, emit }) {
  if (machine && !machine.can.stop) {
    const text = "This panel cannot stop this machine: use its own stop or E-stop.";
    emit("notice", { kind: "notice", level: "warning", text });
    return;
  }
  if (isWriter || !["running", "held"].includes(state?.running)) return;
  const name = state.writer?.name;
  const who = name ? `${name} has control` : "nobody has control";
  const text = `Not stopped: ${who}. Take control, then press Esc again.`;
  emit("notice", { kind: "notice", level: "warning", text });
}

function actOf(event, plain, press) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) {
    if (key === "z") return () => press(event.shiftKey ? "redo" : "undo");
    return key === "y" ? () => press("redo") : null;
  }
  if (event.shiftKey && key === "r") return () => press("reset");
  if (event.shiftKey && key !== "?" && key !== "/") return null;
  return plain[key] ?? null;
}

/** What the machine is, from the server. */
function about(element, machine) {
  const words = [machine?.title, machine?.paper, machine?.notes].filter(Boolean);
  element.replaceChildren(...words.map((text, i) => {
    const line = document.createElement(i ? "p" : "strong");
    line.textContent = text;
    return line;
  }));
}

function fill(dialog) {
  dialog.innerHTML = '<h2 id="keys-title">Help</h2><div id="about"></div><p class="how"></p><dl></dl>'
    + '<button type="button" class="main">Close</button>';
  dialog.querySelector(".how").textContent = "The machine runs in a process of its own: this page, or the loss of it, "
    + "never stops or slows it. The first page has control, the others watch; Release control lets another page take "
    + "it. A change of a parameter takes effect at "
    + "once and without a bump where the controller allows it; the dashed lines show what the previous setting would do.";
  const list = dialog.querySelector("dl");
  for (const [key, words] of KEYS) {
    const term = document.createElement("dt");
    const kbd = document.createElement("kbd");
    kbd.textContent = key;
    term.append(kbd);
    const text = document.createElement("dd");
    text.textContent = words;
    list.append(term, text);
  }
  dialog.querySelector("button").addEventListener("click", () => dialog.close());
}
