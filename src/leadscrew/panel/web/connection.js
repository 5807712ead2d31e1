// The line to the machine: one WebSocket, questions with answers, frames; it comes back by itself when it is lost.

const BACK_OFF_MS = [250, 500, 1000, 2000, 4000, 5000];
const SILENT_MS = 3000; // nothing heard for so long: the line is dead
const PING_MS = 1000;
export const HEADER = 32;

/** The frame in a binary message, or null where it is none that this page knows. */
export function frameOf(buffer) {
  if (buffer.byteLength < HEADER) return null;
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 1) return null;
  const kind = view.getUint8(1);
  const columns = view.getUint16(2, true);
  const rows = view.getUint32(4, true);
  const size = kind === 3 ? 8 : 4;
  if (buffer.byteLength !== HEADER + rows * columns * size) return null;
  const Numbers = kind === 3 ? Float64Array : Float32Array;
  return {
    kind, columns, rows,
    run: view.getUint32(8, true), // of captures: their number
    first: view.getFloat64(16, true),
    stride: view.getFloat64(24, true),
    values: new Numbers(buffer, HEADER, rows * columns),
  };
}

export class Connection {
  /**
   * @param {object} handlers hello() -> what the first message says; shut() -> a promise of the sentence why the server
   *   lets this page in no more, "" where it does or is not there; onHello(result), onRefused(error), onText(object),
   *   onFrame(frame), onLink("connecting" | "open" | "lost", text)
   */
  constructor(url, handlers) {
    this.url = url;
    this.handlers = handlers;
    this.number = 0;
    this.waiting = new Map();
    this.tries = 0;
    this.ready = false;
    this.heard = 0;
    setInterval(() => this.watch(), PING_MS);
  }

  open() {
    clearTimeout(this.later);
    this.handlers.onLink(this.tries ? "lost" : "connecting", this.tries ? "trying again" : "connecting");
    const socket = new WebSocket(this.url, ["leadscrew.1"]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.heard = performance.now();
    socket.onopen = () => this.greet(socket);
    socket.onmessage = (message) => { if (socket === this.socket) this.take(message.data); };
    socket.onclose = (event) => { if (socket === this.socket) this.closed(socket, event.reason); };
  }

  /** The line ended. A browser does not tell a page why it got no line; that is asked for. */
  async closed(socket, reason) {
    const why = this.ready || this.refused ? "" : await this.handlers.shut();
    if (socket !== this.socket) return;
    if (why) {
      this.refused = true;
      this.handlers.onRefused(new Error(why));
    }
    this.lost(reason);
  }

  async greet(socket) {
    try {
      const result = await this.ask("hello", this.handlers.hello());
      if (socket !== this.socket) return;
      this.tries = 0;
      this.ready = true;
      this.handlers.onHello(result);
      this.handlers.onLink("open", "connected");
    } catch (error) {
      if (socket === this.socket && !error.lost) {
        this.refused = true;
        this.handlers.onRefused(error);
      }
    }
  }

  take(data) {
    this.heard = performance.now();
    if (typeof data !== "string") {
      const frame = frameOf(data);
      if (frame) this.handlers.onFrame(frame);
      return;
    }
    const message = JSON.parse(data);
    if (message.re === undefined) {
      this.handlers.onText(message);
      return;
    }
    const asked = this.waiting.get(message.re);
    this.waiting.delete(message.re);
    if (!asked) return;
    if (message.ok) asked.resolve(message.result ?? {});
    else asked.reject(Object.assign(new Error(message.error ?? "refused"), { key: message.key }));
  }

  /** The answer to a question; refused with the server's sentence, or with `lost` set where no answer can come. */
  ask(what, args = {}) {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN) {
      const error = new Error("Not connected: nothing was sent to the machine.");
      return Promise.reject(Object.assign(error, { lost: true }));
    }
    this.number += 1;
    const id = this.number;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      socket.send(JSON.stringify({ id, do: what, ...args }));
    });
  }

  lost(reason) {
    this.ready = false;
    for (const asked of this.waiting.values()) {
      asked.reject(Object.assign(new Error("The connection was lost before the machine answered."), { lost: true }));
    }
    this.waiting.clear();
    if (this.refused) return;
    const wait = BACK_OFF_MS[Math.min(this.tries, BACK_OFF_MS.length - 1)] * (0.8 + 0.4 * Math.random());
    this.tries += 1;
    this.handlers.onLink("lost", reason || "connection lost");
    this.later = setTimeout(() => this.open(), wait);
  }

  /** Opens the line anew at once (another name). */
  again() {
    this.refused = false;
    const socket = this.socket;
    this.socket = null;
    if (socket) socket.close();
    this.lost("");
    this.tries = 0;
    this.open();
  }

  watch() {
    if (!this.ready) return;
    if (performance.now() - this.heard > SILENT_MS) {
      const socket = this.socket;
      this.socket = null;
      socket.close();
      this.lost("nothing heard from the machine");
      return;
    }
    this.ask("ping", { t: performance.now() }).catch(() => {});
  }
}
