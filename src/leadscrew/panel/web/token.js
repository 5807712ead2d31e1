// The word that a panel served beyond this machine asks for.

const KEY = "leadscrew.token";

/** The token from the address (#token=... or ?token=..., taken out of it at once) or this tab's memory; or null. */
export function rememberedToken() {
  const address = new URL(location.href);
  const token = new URLSearchParams(address.hash.slice(1)).get("token") ?? address.searchParams.get("token");
  try {
    if (token) {
      sessionStorage.setItem(KEY, token);
      address.hash = "";
      address.searchParams.delete("token");
      history.replaceState(null, "", address);
    }
    return token ?? sessionStorage.getItem(KEY);
  } catch {
    return token;
  }
}

/** Asks for the token when the first message was refused. */
export function mountToken(element, panel) {
  element.innerHTML = `<form method="dialog">
    <h2 id="token-title">The panel refused the connection</h2>
    <p class="sentence" role="alert"></p>
    <label>Token <input type="password" autocomplete="off" required></label>
    <p>The token was printed where the panel was started.</p>
    <button type="submit" class="main">Connect</button></form>`;
  element.addEventListener("cancel", (event) => event.preventDefault()); // without it there is no panel
  const field = element.querySelector("input");
  panel.on("link", ({ link, text }) => {
    if (link !== "refused") return;
    element.querySelector(".sentence").textContent = text;
    if (!element.open) element.showModal();
    field.focus();
  });
  element.querySelector("form").addEventListener("submit", () => {
    panel.token = field.value;
    field.value = "";
    try {
      sessionStorage.setItem(KEY, panel.token);
    } catch { /* a browser that keeps nothing */ }
    panel.hello();
  });
}
