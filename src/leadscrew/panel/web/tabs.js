// The tabs of the middle: Live, Scope, Why.

export function mountTabs(element, panel) {
  const tabs = [...element.querySelectorAll('[role="tab"]')];
  const choose = (tab, focus) => {
    for (const other of tabs) {
      const is = other === tab;
      other.setAttribute("aria-selected", String(is));
      other.tabIndex = is ? 0 : -1;
      document.getElementById(other.getAttribute("aria-controls")).hidden = !is;
    }
    if (focus) tab.focus();
    panel.view = tab.id.slice(4);
    panel.emit("view", panel.view);
  };
  for (const [i, tab] of tabs.entries()) {
    tab.addEventListener("click", () => choose(tab));
    tab.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (by) choose(tabs[(i + by + tabs.length) % tabs.length], true);
    });
  }
  panel.show = (view) => choose(document.getElementById(`tab-${view}`));
}
