/** Tells whether an element can be seen: its tab is chosen and the browser's window is not hidden. */
export function seen(element, tell) {
  let inside = false, last = null;
  const say = () => {
    const now = inside && document.visibilityState === "visible";
    if (now !== last) tell((last = now));
  };
  new IntersectionObserver((entries) => {
    inside = entries.at(-1).isIntersecting;
    say();
  }).observe(element);
  document.addEventListener("visibilitychange", say);
}
