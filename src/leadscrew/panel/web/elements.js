/** Building the page from data: text is always set as text, so that a name can never become markup. */

let count = 0;

/**
 * An element with properties and children.
 * @param {string} tag
 * @param {object} [properties] `class`, `on` (event name to function), `data`, `aria-*`, `role`
 *   and `for` as attributes, all else as properties of the element
 * @param {...(Node|string|null|undefined|false)} children strings become text; nothing, null and false are left out
 */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name === "class") element.className = value;
    else if (name === "on") for (const [event, act] of Object.entries(value)) element.addEventListener(event, act);
    else if (name === "data") Object.assign(element.dataset, value);
    else if (/^(aria-|role$|for$|scope$|list$)/.test(name)) element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children.filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

/** A field under its label. The field gets an id where it has none. */
export function labelled(text, field, unit = "") {
  field.id = field.id || `side-${++count}`;
  const label = make("label", { for: field.id, class: "side-label" }, text);
  return make("div", { class: "side-field" }, label,
    make("span", { class: "side-entry" }, field, unit && make("span", { class: "side-unit" }, unit)));
}

/** A selection from `[value, text]` pairs. */
export function choice(pairs, value, onChange) {
  const field = make("select", { on: { change: () => onChange?.(field.value) } });
  field.append(...pairs.map(([v, text]) => make("option", { value: v }, text)));
  field.value = value;
  return field;
}

/** A button that does something, and says so where that fails. */
export function button(text, act, properties = {}) {
  return make("button", { type: "button", ...properties, on: { click: act } }, text);
}

/** Sets the text of an element where it is another: nothing is laid out anew for the same words. */
export function put(node, text) { if (node.textContent !== text) node.textContent = text; }

/** Puts children in place of what was there. */
export function fill(element, ...children) {
  element.replaceChildren(...children.filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

/**
 * A button that asks again in its own place before it does what cannot be taken back.
 * It returns to its first text after four seconds or when it loses the focus.
 */
export function careful(text, question, act, properties = {}) {
  let asked = false, timer = 0;
  const calm = () => {
    asked = false;
    clearTimeout(timer);
    own.textContent = text;
    own.classList.remove("side-asking");
  };
  const own = button(text, () => {
    if (asked) {
      calm();
      act();
      return;
    }
    asked = true;
    own.textContent = question;
    own.classList.add("side-asking");
    timer = setTimeout(calm, 4000);
  }, properties);
  own.addEventListener("blur", calm);
  return own;
}
