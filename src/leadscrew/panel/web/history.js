// The rows that the machine sent, in rings: one preallocated Float32Array a column, so that memory never grows.

const BYTES = 28e6; // for all columns of one history together
const LONGEST = 65536; // rows

function capacityFor(columns) {
  let rows = 1024;
  while (rows * 2 <= LONGEST && rows * 2 * 4 * Math.max(1, columns) <= BYTES) rows *= 2;
  return rows;
}

/** Rows by their serial number: the first row ever pushed is 0, the newest is `serial - 1`; `oldest` is still held. */
export class History {
  /** @param {string[]} names columns in the order of the frames, without "time" */
  constructor(names, capacity = capacityFor(names.length)) {
    this.capacity = capacity; // a power of two
    this.mask = capacity - 1;
    this.periods = new Float64Array(capacity);
    this.rings = new Map(); // name -> Float32Array(capacity), filled with NaN so that its memory is taken at once
    this.keep(names);
    this.clear();
  }

  /** Other columns from now on (a switched controller); columns of the same name keep their rows. */
  keep(names) {
    const rings = new Map();
    for (const name of names) rings.set(name, this.rings.get(name) ?? new Float32Array(this.capacity).fill(NaN));
    this.rings = rings;
    this.names = names.slice();
    this.data = names.map((name) => rings.get(name)); // by number of the column
  }

  clear() {
    this.serial = 0; // rows pushed so far
    this.last = -1; // period number of the newest row
    this.gaps = []; // [period before, period after] where rows are missing; the last 16
  }

  get size() { return Math.min(this.serial, this.capacity); }
  get oldest() { return this.serial - this.size; }

  /** Rows of a frame: row i is of period `first + i * stride`; rows already held are passed over. */
  push(first, stride, rows, values) {
    const columns = this.data.length;
    let from = 0;
    while (from < rows && first + from * stride <= this.last) from += 1;
    if (from >= rows) return 0;
    const start = first + from * stride;
    if (this.serial && start - this.last > 2.5 * Math.max(stride, this.stride ?? stride)) {
      this.gaps.push([this.last, start]);
      if (this.gaps.length > 16) this.gaps.shift();
    }
    this.stride = stride;
    for (let row = from, at = this.serial; row < rows; row += 1, at += 1) {
      this.periods[at & this.mask] = first + row * stride;
    }
    for (let column = 0; column < columns; column += 1) {
      const ring = this.data[column];
      for (let row = from, at = this.serial; row < rows; row += 1, at += 1) {
        ring[at & this.mask] = values[row * columns + column];
      }
    }
    this.serial += rows - from;
    this.last = first + (rows - 1) * stride;
    return rows - from;
  }

  period(serial) { return this.periods[serial & this.mask]; }

  /** Value of a column (name or number) at a row; NaN where there is no such column. */
  value(column, serial) {
    const ring = typeof column === "number" ? this.data[column] : this.rings.get(column);
    return ring ? ring[serial & this.mask] : NaN;
  }

  /** The last `n` values of a column, oldest first, in `out` (made where none is given). */
  tail(column, n, out = new Float32Array(Math.min(n, this.size))) {
    const rows = Math.min(n, this.size, out.length);
    for (let i = 0; i < rows; i += 1) out[i] = this.value(column, this.serial - rows + i);
    return out.subarray(0, rows);
  }

  /** Serial number of the first row held whose period is not before `period`; `serial` where there is none. */
  find(period) {
    let low = this.oldest;
    let high = this.serial;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.period(middle) < period) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
