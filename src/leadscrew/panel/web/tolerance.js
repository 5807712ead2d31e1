// A value axis that shows the tolerance of a plot, whatever else happens in it.

const WIDTHS = 3; // of the bands together, from the lower to the upper end of the axis

/**
 * The axis about the bands of a plot.
 * @param {{low: number, high: number, about: string}[]} bands in the shown unit
 * @param {(band: object) => number} about the value now of the signal that a band lies about
 * @returns {{min: number, max: number} | null} null where no band has a place yet
 */
export function toleranceAxis(bands, about) {
  let low = Infinity, high = -Infinity;
  for (const band of bands) {
    const middle = band.about ? about(band) : 0;
    if (!Number.isFinite(middle)) continue;
    low = Math.min(low, middle + band.low);
    high = Math.max(high, middle + band.high);
  }
  if (!(low < high)) return null;
  const air = ((WIDTHS - 1) / 2) * (high - low);
  return { min: low - air, max: high + air };
}
