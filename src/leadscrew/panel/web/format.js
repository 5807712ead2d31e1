// Numbers, units and colours as the page shows them.

const COLOURS = {
  command: "#000000", feedback: "#0072B2", actual: "#56B4E9", error: "#D55E00", output: "#009E73",
  disturbance: "#CC79A7", other: "#E69F00",
}; // Okabe and Ito, as leadscrew.report.style
const ORDER = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];
export const ROLES = {
  command: "command", feedback: "measured", actual: "true value", error: "error", output: "controller output",
  disturbance: "disturbance", other: "",
};

/** One colour a trace of a plot: that of its role, or the next free one where the role comes again. */
export function coloursOf(traces) {
  const used = new Set();
  return traces.map((trace) => {
    const wanted = COLOURS[trace.role] ?? COLOURS.other;
    const found = used.has(wanted) ? ORDER.find((colour) => !used.has(colour)) ?? wanted : wanted;
    used.add(found);
    return found;
  });
}

/** `#rrggbb` with an opacity, for canvas. */
export function faint(colour, opacity) {
  const part = (from) => parseInt(colour.slice(from, from + 2), 16);
  return `rgba(${part(1)}, ${part(3)}, ${part(5)}, ${opacity})`;
}

/** A unit as people write it: um is µm, mm/s^2 is mm/s². "1" is no unit. */
export function unit(text) {
  if (!text || text === "1") return "";
  return String(text).replace(/\bum\b/g, "µm").replace(/\burad\b/g, "µrad").replace(/\bdeg\b/g, "°")
    .replace(/\^2/g, "²").replace(/\^3/g, "³").replace(/\bN m\b/g, "N·m");
}

/** A sentence with um and degrees written as people write them. */
export function micro(text) { return text.replace(/\bum\b/g, "µm").replace(/(\d) deg\b/g, "$1°"); }

/** A number with so many significant digits; true minus sign left out on purpose, so that it can be typed back. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (typeof value === "string") return value; // an option
  if (!Number.isFinite(value)) return value > 0 ? "unlimited" : "-unlimited";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
  const text = value.toPrecision(digits);
  return text.includes(".") && !text.includes("e") ? text.replace(/\.?0+$/, "") : String(Number(text));
}

/** A value beside a moving plot: always as wide, so that it does not dance. */
export function steady(value) {
  if (!Number.isFinite(value)) return "-";
  const size = Math.abs(value) < 1e-15 ? 0 : Math.abs(value);
  if (size !== 0 && (size >= 1e5 || size < 5e-5)) return value.toExponential(2);
  const places = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : 4;
  return (size ? value : 0).toFixed(places);
}

export function withUnit(value, of, digits = 4) {
  const shown = unit(of);
  return shown ? `${number(value, digits)} ${shown}` : number(value, digits);
}

/** The exact value for an entry field: the shortest text that gives the same number back. */
export function exact(value) {
  return typeof value === "number" ? String(value).replace("e+", "e") : String(value ?? "");
}

/** As exact, but with no more digits than fit a field. */
export function brief(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return exact(value);
  const text = exact(Number(value.toPrecision(7)));
  return text.length > 10 ? exact(Number(value.toPrecision(6)).toExponential()) : text;
}

/** What was typed as a number, or NaN: spaces are left out, one comma is a decimal point. */
export function typed(text) {
  const plain = text.trim().replace(/\s/g, "").replace(/^([+-]?\d*),(\d+([eE][+-]?\d+)?)$/, "$1.$2");
  const value = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/.test(plain) ? Number(plain) : NaN;
  return Number.isFinite(value) ? value : NaN; // 1e400 is none that a machine can hold
}

/** Seconds for a clock: 12.345 s, 3 min 05.0 s. */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return "-";
  if (seconds < 60) return `${seconds.toFixed(3)} s`;
  const minutes = Math.floor(seconds / 60);
  return `${minutes} min ${(seconds - 60 * minutes).toFixed(1).padStart(4, "0")} s`;
}

/** The time of day of a date; what is no date as it is. */
export function timeOfDay(when) {
  const date = new Date(when);
  return Number.isNaN(date.getTime()) ? String(when ?? "") : date.toLocaleTimeString([], { hour12: false });
}

/** Allowed range in words. */
export function bounds({ low, high, low_open: lowOpen, high_open: highOpen }) {
  const has = (value) => value !== null && value !== undefined && Number.isFinite(value);
  const from = `${lowOpen ? "above " : ""}${number(low)}`;
  if (has(low) && has(high)) return `${from} to ${highOpen ? "below " : ""}${number(high)}`;
  if (has(low)) return `${lowOpen ? "above" : "from"} ${number(low)}`;
  if (has(high)) return `${highOpen ? "below" : "up to"} ${number(high)}`;
  return "any number";
}

const PARTS = [[1, "s"], [1e-3, "ms"], [1e-6, "µs"]];

/** @returns {string} seconds in s, ms or us */
export function duration(seconds, digits = 5) {
  if (!Number.isFinite(seconds)) return "-";
  const size = Math.abs(seconds);
  if (size < 1e-12) return "0 s";
  const [part, unit] = PARTS.find(([p]) => size >= p * 0.99999) ?? PARTS[2];
  return `${number(seconds / part, digits)} ${unit}`;
}

/** @returns {string} one over a number of seconds, in Hz or kHz */
export function frequency(seconds) {
  if (!(Math.abs(seconds) > 1e-12)) return "-";
  const hertz = 1 / Math.abs(seconds);
  return hertz >= 1000 ? `${number(hertz / 1000)} kHz` : `${number(hertz)} Hz`;
}

/** @returns {string} a value of the audit trail or of a parameter, short and on one line */
export function plain(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return String(Number(value.toPrecision(6)));
  if (typeof value === "string" || typeof value === "boolean") return String(value);
  const flat = !Array.isArray(value) && Object.values(value).every((v) => v === null || typeof v !== "object");
  const text = flat ? Object.entries(value).map(([k, v]) => `${k} ${plain(v)}`).join(", ") : JSON.stringify(value);
  return text.length > 120 ? `${text.slice(0, 117)}...` : text;
}

/** @returns {string} a number of bytes in kB or MB */
export function bytes(count) {
  return count >= 1e6 ? `${number(count / 1e6, 3)} MB` : `${number(Math.max(0.1, count / 1e3), 3)} kB`;
}
