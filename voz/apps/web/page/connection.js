// The connection to the robot: receives records, sends requests, and reconnects by itself.

const RETRY_DELAYS = [300, 600, 1000, 2000]; // ms; the last one repeats
const STATE_TIMEOUT = 1500; // ms without a state until the connection is lost
const STOP_TIMEOUT = 1500; // ms

export class Connection {
  // `onRecord` gets each record, `onLost` the reason when the connection is lost.
  constructor(onRecord, onLost) {
    this.onRecord = onRecord;
    this.onLost = onLost;
    this.tries = 0;
    this.stops = 0;
    this.pendingStops = new Map();
    this.secret = null;
    this.socket = null;
  }

  // `stop` works before that, too.
  start() {
    setInterval(() => this.checkAlive(), 500);
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/events`);
    this.socket = socket;
    this.lastRecord = performance.now();
    socket.onmessage = (message) => this.receive(JSON.parse(message.data));
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.secret = null;
      this.onLost(event.reason);
      setTimeout(() => this.open(), RETRY_DELAYS[Math.min(this.tries++, RETRY_DELAYS.length - 1)]);
    };
  }

  // A connection that delivers nothing is closed: the robot may be gone without a word.
  checkAlive() {
    const open = this.socket?.readyState === WebSocket.OPEN;
    if (open && performance.now() - this.lastRecord > STATE_TIMEOUT) {
      const socket = this.socket;
      this.socket = null;
      socket.close();
      this.secret = null;
      this.onLost("");
      this.open();
    }
  }

  receive(record) {
    this.lastRecord = performance.now();
    if (record.type === "welcome") {
      this.tries = 0;
      this.secret = record.secret;
    } else if (record.type === "state" && this.isAttended()) {
      this.send("seen");
    } else if (record.type === "stop") {
      this.pendingStops.get(record.number)?.(record);
    }
    this.onRecord(record);
  }

  // An operator who does not see the page cannot stop the robot by it.
  isAttended() {
    return !document.hidden || Boolean(this.handsFree);
  }

  send(type, more = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ type, ...more }));
    return true;
  }

  command(text) {
    return this.post("/api/command", { text, stops: this.stops });
  }

  // Send a request as this page.
  async post(address, more) {
    const body = JSON.stringify({ ...more, page: this.secret });
    const answer = await fetch(address, {
      method: "POST", headers: { "Content-Type": "application/json" }, body,
    });
    const record = await answer.json();
    if (!answer.ok) throw new Error(record.error);
    return record;
  }

  // By WebSocket and by POST at once: the first confirmation counts.
  async stop() {
    const number = ++this.stops;
    const answers = [this.stopBySocket(number), this.stopByPost(number)];
    try {
      return await Promise.any(answers);
    } finally {
      this.pendingStops.delete(number);
    }
  }

  stopBySocket(number) {
    return new Promise((resolve, reject) => {
      this.pendingStops.set(number, (record) => (record.stopped ? resolve(record) : reject(new Error(record.error))));
      if (!this.send("stop", { number })) reject(new Error("no connection"));
      setTimeout(() => reject(new Error("no answer")), STOP_TIMEOUT);
    });
  }

  async stopByPost(number) {
    const headers = this.secret ? { "X-Voz-Page": this.secret, "X-Voz-Stop": String(number) } : {};
    const answer = await fetch("/api/stop", { method: "POST", headers, signal: AbortSignal.timeout(STOP_TIMEOUT) });
    const record = await answer.json();
    if (!record.stopped) throw new Error(record.error);
    return record;
  }
}
