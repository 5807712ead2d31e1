// Which values a slider stands for: the allowed range, or a range around the default where that is unlimited or huge.

export const STEPS = 1000;

/** {value(position), position(value)} for positions 0 to STEPS; null where a slider makes no sense. */
export function scaleOf(parameter) {
  const { type, default: start } = parameter;
  if (type !== "float" && type !== "int") return null;
  if (!Number.isFinite(start)) return null;
  const low = finite(parameter.low) ? parameter.low : -Infinity;
  const high = finite(parameter.high) ? parameter.high : Infinity;
  const wide = high - low;
  if (Number.isFinite(wide) && low > 0 && high / low >= 100 && type === "float") return log(low, high, 1);
  if (Number.isFinite(wide) && (wide <= 25 * Math.abs(start - low) || start === 0)) return linear(low, high, parameter);
  const least = type === "int" ? Math.min(0, 4 * start) : -1;
  const most = type === "int" ? Math.max(10, 4 * start) : 1;
  if (type === "int" || start === 0) return linear(Math.max(low, least), Math.min(high, most), parameter);
  if (Math.abs(start) >= 1e6) return null; // "never" and the like
  const smallest = Math.max(Math.abs(start) / 10, start > 0 && low > 0 ? low : 0);
  const largest = Math.min(Math.abs(start) * 10, start > 0 ? high : -low);
  return largest > smallest ? log(smallest, largest, Math.sign(start)) : null;
}

function finite(value) { return typeof value === "number" && Number.isFinite(value); }

/** Three significant digits, kept inside the bounds. */
function round(value, low, high) {
  const rounded = Number(value.toPrecision(3));
  return Math.min(high, Math.max(low, rounded));
}

function log(least, most, sign) {
  const span = Math.log(most / least);
  const part = (at) => (sign > 0 ? at : 1 - at);
  return {
    value: (position) => {
      const size = least * Math.exp(span * part(position / STEPS));
      if (position <= 0 || position >= STEPS) return sign * (part(position / STEPS) < 0.5 ? least : most);
      return sign * round(size, least, most);
    },
    position: (value) => {
      const at = Math.log(Math.min(most, Math.max(least, sign * value)) / least) / span;
      return STEPS * (Number.isFinite(at) ? part(at) : 0);
    },
  };
}

function linear(low, high, { type, low_open: lowOpen, high_open: highOpen }) {
  if (!(high > low)) return null;
  const inside = (position) => Math.min(STEPS - (highOpen ? 1 : 0), Math.max(lowOpen ? 1 : 0, position));
  const step = (high - low) / STEPS;
  return {
    value: (position) => {
      const exact = low + (high - low) * (inside(position) / STEPS);
      if (type === "int") return Math.round(exact);
      const digits = Math.max(0, Math.min(12, 1 - Math.floor(Math.log10(step))));
      return Math.min(high, Math.max(low, Number(exact.toFixed(digits))));
    },
    position: (value) => Math.min(STEPS, Math.max(0, ((value - low) / (high - low)) * STEPS)),
  };
}
