// On the link's thread: the connection for events, which answers the robot's states for the page.

const RETRY_DELAYS = [300, 600, 1000, 2000]; // ms; the last one repeats
const STATE_TIMEOUT = 1500; // ms without a state until the connection is lost

// A page that has shown nothing for so long is not answered for, ms: as long as it hangs, nobody can press STOP
// on it. What phones need for a layout or the collection of garbage is below half of that.
const PAGE_TIMEOUT = 1000;

export class EventSocket {
  // `tell` sends a message to the page: each record, and that the connection is open or lost.
  constructor(tell) {
    this.tell = tell;
    this.tries = 0;
    this.socket = null;
    this.shownAt = -Infinity; // when the last record that the page has shown had come, ms
    this.attended = true;
    this.unanswered = false; // whether a state waits for the page
    setInterval(() => this.checkAlive(), 500);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/events`);
    this.socket = socket;
    this.lastRecord = performance.now();
    socket.onmessage = (message) => this.receive(JSON.parse(message.data));
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.tell({ type: "lost", reason: event.reason });
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
      this.tell({ type: "lost", reason: "" });
      this.open();
    }
  }

  receive(record) {
    this.lastRecord = performance.now();
    if (record.type === "welcome") this.tries = 0;
    this.tell({ type: "record", record, at: this.lastRecord });
    if (record.type !== "state") return;
    this.unanswered = true;
    this.answer();
  }

  // The page has shown the record that came at a time.
  pageShowed(at, attended) {
    this.shownAt = at;
    this.setAttended(attended);
    this.answer();
  }

  setAttended(attended) {
    this.attended = attended;
  }

  // Whether somebody can see the page, and press STOP on it.
  isPageThere() {
    return this.attended && performance.now() - this.shownAt < PAGE_TIMEOUT;
  }

  answer() {
    if (this.unanswered && this.isPageThere()) this.unanswered = !this.send({ type: "seen" });
  }

  // Returns whether it was sent.
  send(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
