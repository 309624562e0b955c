// The connection to the robot: receives records, and sends requests. It reconnects by itself.
import { link } from "./link.js";
import { text, translate } from "./texts.js";

const STOP_TIMEOUT = 1500; // ms

export class Connection {
  // `onRecord` gets each record, `onLost` the reason when the connection is lost.
  constructor(onRecord, onLost) {
    this.onRecord = onRecord;
    this.onLost = onLost;
    this.stops = 0;
    this.pendingStops = new Map();
    this.secret = null; // while it is connected
    link.addEventListener("message", ({ data }) => {
      if (data.type === "record") this.receive(data);
      else if (data.type === "lost") this.lose(data.reason);
    });
    link.onerror = () => this.lose(text("This page is broken: load it anew."));
    document.addEventListener("visibilitychange", () => {
      link.postMessage({ type: "attended", attended: this.isAttended() });
    });
  }

  // `stop` works before that, too.
  start() {
    link.postMessage({ type: "open" });
  }

  receive({ record, at }) {
    if (record.type === "welcome") {
      this.secret = record.secret;
    } else if (record.type === "stop") {
      this.pendingStops.get(record.number)?.(record);
    }
    this.onRecord(record);
    link.postMessage({ type: "seen", at, attended: this.isAttended() });
  }

  lose(reason) {
    this.secret = null;
    this.onLost(reason);
  }

  // An operator who does not see the page cannot stop the robot by it.
  isAttended() {
    return !document.hidden || Boolean(this.handsFree);
  }

  // Returns whether there is a connection.
  send(type, more = {}) {
    link.postMessage({ type: "send", message: { type, ...more } });
    return this.secret !== null;
  }

  command(sentence) {
    return this.post("/api/command", { text: sentence, stops: this.stops });
  }

  // Send a request as this page.
  async post(address, more) {
    const body = JSON.stringify({ ...more, page: this.secret });
    const answer = await fetch(address, {
      method: "POST", headers: { "Content-Type": "application/json" }, body,
    });
    const record = await answer.json();
    if (!answer.ok) throw new Error(translate(record.error));
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
