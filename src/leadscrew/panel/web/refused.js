// What is shown where the panel did not let this page in: the server's sentence, and a button to try again.

export function mountRefused(element, panel) {
  element.innerHTML = `<form method="dialog">
    <h2 id="refused-title">The panel refused the connection</h2>
    <p class="sentence" role="alert"></p>
    <button type="submit" class="main">Try again</button></form>`;
  element.addEventListener("cancel", (event) => event.preventDefault()); // without a connection there is no panel
  panel.on("link", ({ link, text }) => {
    if (link === "open") element.close();
    if (link !== "refused") return;
    element.querySelector(".sentence").textContent = text;
    if (!element.open) element.showModal();
  });
  element.querySelector("form").addEventListener("submit", () => panel.hello());
}
