// What is asked for seldom: two axes on a circle, another seed of the noise, the name of who sits here.

export function mountOptions(dialog, panel) {
  dialog.innerHTML = `<form method="dialog"><h2 id="options-title">Options</h2>
    <label class="line" id="option-circle"><input type="checkbox"> <span>Two axes, a circle between them: the view Why
      then draws the ball bar. Y runs beside X with the same parameters.</span></label>
    <label class="line">Seed of the noise <input type="text" inputmode="numeric" size="10" autocomplete="off"></label>
    <p class="doc">Both begin a new run, at rest, with the defaults of the scenario.</p>
    <p class="error" role="alert"></p>
    <button type="button" class="main" id="new-run">New run with these</button>
    <hr><label class="line">Your name, for the log and the other pages
      <input type="text" maxlength="40" autocomplete="off"></label>
    <button type="submit">Close</button></form>`;
  const [circle, seed, name] = dialog.querySelectorAll("input");
  const error = dialog.querySelector(".error");
  const run = dialog.querySelector("#new-run");
  const runs = [seed.parentElement, dialog.querySelector(".doc"), run, dialog.querySelector("hr")];
  const allow = () => {
    const moving = ["running", "building"].includes(panel.state?.running);
    run.disabled = !panel.connected || !panel.isWriter || moving || !panel.machine?.simulated;
    run.title = moving ? "Stop or hold the machine first." : panel.isWriter ? "" : "Take control first.";
  };
  document.getElementById("options").addEventListener("click", () => {
    const { machine } = panel;
    error.textContent = "";
    dialog.querySelector("#option-circle").hidden = !machine?.can.circle;
    for (const part of runs) part.hidden = machine?.simulated === false; // a real machine is not begun anew from here
    circle.checked = Boolean(machine?.circle);
    seed.value = String(machine?.seed ?? 0);
    name.value = panel.name;
    allow();
    dialog.showModal();
  });
  for (const kind of ["state", "writer", "link"]) panel.on(kind, allow);
  run.addEventListener("click", async () => {
    const { study, controller, scenario, can } = panel.machine;
    const number = /^\d{1,10}$/.test(seed.value.trim()) ? Number(seed.value) : NaN;
    error.textContent = number < 2 ** 31 ? "" : `Seed ${seed.value}: expected a whole number from 0 to ${2 ** 31 - 1}.`;
    if (error.textContent) return;
    try {
      await panel.send("machine", { study, controller, scenario, seed: number, circle: can.circle && circle.checked });
      dialog.close();
    } catch (refused) {
      error.textContent = refused.message;
    }
  });
  name.addEventListener("change", () => rename(panel, name.value.trim().slice(0, 40)));
}

function rename(panel, name) {
  if (!name || name === panel.name) return;
  panel.name = name;
  try {
    localStorage.setItem("leadscrew.name", name);
  } catch { /* a browser that keeps nothing */ }
  panel.hello(); // the server learns a name when a page comes
}
