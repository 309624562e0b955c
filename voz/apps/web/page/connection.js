// The way to the robot: told what happens, asks for things, and comes back by itself.

const AGAIN = [300, 600, 1000, 2000]; // ms until the next try; the last one goes on
const SILENT = 1500; // ms without a state, and the way is lost
const STOP_PATIENCE = 1500; // ms

export class Connection {
  // `told` gets what comes, `lost` is called when the way is.
  constructor(told, lost) {
    this.told = told;
    this.lost = lost;
    this.tries = 0;
    this.number = 0;
    this.stopping = new Map();
    this.secret = null;
    this.socket = null;
  }

  // It stops the robot before that, too.
  begin() {
    setInterval(() => this.look(), 500);
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/events`);
    this.socket = socket;
    this.last = performance.now();
    socket.onmessage = (message) => this.take(JSON.parse(message.data));
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.secret = null;
      this.lost(event.reason);
      setTimeout(() => this.open(), AGAIN[Math.min(this.tries++, AGAIN.length - 1)]);
    };
  }

  // A way that gives nothing is closed: what is behind it may be gone without a word.
  look() {
    const open = this.socket?.readyState === WebSocket.OPEN;
    if (open && performance.now() - this.last > SILENT) {
      const socket = this.socket;
      this.socket = null;
      socket.close();
      this.secret = null;
      this.lost("");
      this.open();
    }
  }

  take(record) {
    this.last = performance.now();
    if (record.type === "welcome") {
      this.tries = 0;
      this.secret = record.secret;
    } else if (record.type === "state" && this.answers()) {
      this.send("seen");
    } else if (record.type === "stop") {
      this.stopping.get(record.number)?.(record);
    }
    this.told(record);
  }

  // An operator who does not see the page cannot stop the robot by it.
  answers() {
    return !document.hidden || Boolean(this.handsFree);
  }

  send(type, more = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ type, ...more }));
    return true;
  }

  command(text) {
    return this.ask("/api/command", { text, stops: this.number });
  }

  // Send something to an address as this page.
  async ask(address, more) {
    const body = JSON.stringify({ ...more, page: this.secret });
    const answer = await fetch(address, {
      method: "POST", headers: { "Content-Type": "application/json" }, body,
    });
    const record = await answer.json();
    if (!answer.ok) throw new Error(record.error);
    return record;
  }

  // By both ways at once: the first that says that the robot is stopped counts.
  async stop() {
    const number = ++this.number;
    const ways = [this.stopBySocket(number), this.stopByPost(number)];
    try {
      return await Promise.any(ways);
    } finally {
      this.stopping.delete(number);
    }
  }

  stopBySocket(number) {
    return new Promise((resolve, reject) => {
      this.stopping.set(number, (record) => (record.stopped ? resolve(record) : reject(new Error(record.error))));
      if (!this.send("stop", { number })) reject(new Error("no connection"));
      setTimeout(() => reject(new Error("no answer")), STOP_PATIENCE);
    });
  }

  async stopByPost(number) {
    const headers = this.secret ? { "X-Voz-Page": this.secret, "X-Voz-Stop": String(number) } : {};
    const answer = await fetch("/api/stop", { method: "POST", headers, signal: AbortSignal.timeout(STOP_PATIENCE) });
    const record = await answer.json();
    if (!record.stopped) throw new Error(record.error);
    return record;
  }
}
