// On the link's thread: the connection for the microphone's sound, which comes from the thread that captures it.

const HEADER = 16; // bytes: the number of the block, 0, and when it was heard
const TAIL = 400; // ms that are still sent when the button is released: the end of the last word
const MAX_BUFFERED = 0.3; // s of sound that wait for a slow network; more is dropped, and the robot sees the gap
const RECONNECT_DELAY = 1000; // ms

export class SoundSocket {
  // `tell` sends a message to the page; while `isPageThere` returns false, no sound is sent.
  constructor(tell, isPageThere) {
    this.tell = tell;
    this.isPageThere = isPageThere;
    this.talking = this.held = false;
    this.number = 0;
    this.rate = 0; // Hz; 0 without a microphone
  }

  // Take blocks of sound from a port.
  listenTo(port, rate) {
    this.rate = rate;
    port.onmessage = ({ data }) => this.sendBlock(data);
  }

  // Open the connection, with the secret of the driving page; the page knows it by the number.
  connect(secret, connection) {
    this.disconnect();
    if (!this.rate) return;
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/audio`);
    socket.onopen = () => socket.send(JSON.stringify({ type: "hello", page: secret, rate: this.rate }));
    socket.onmessage = ({ data }) => this.receive(socket, connection, JSON.parse(data));
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.disconnect();
      this.tell({ type: "sound-broken", connection });
      this.opening = setTimeout(() => this.connect(secret, connection), RECONNECT_DELAY);
    };
    this.socket = socket;
  }

  disconnect() {
    clearTimeout(this.opening);
    clearTimeout(this.ending);
    this.socket?.close();
    this.socket = null;
    this.talking = false;
  }

  receive(socket, connection, record) {
    if (record.type === "ping") {
      socket.send(JSON.stringify({ type: "pong", t: record.t, at: Date.now() }));
      this.tell({ type: "sound-ready", connection });
    } else if (record.type === "late") {
      this.tell({ type: "sound-late", connection, seconds: record.seconds });
    }
  }

  // What is said hands-free must not count as held, nor the other way round.
  begin(held) {
    clearTimeout(this.ending);
    const goesOn = this.talking && held === this.held;
    if (goesOn || !this.isOpen()) return;
    this.socket.send(JSON.stringify({ type: "begin", held }));
    this.talking = true;
    this.held = held;
  }

  // The last word is still sent.
  end() {
    clearTimeout(this.ending);
    this.ending = setTimeout(() => {
      if (this.talking && this.isOpen()) this.socket.send('{"type":"end"}');
      this.talking = false;
    }, TAIL);
  }

  isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  sendBlock({ heard, samples }) {
    if (!this.talking || !this.isOpen()) return;
    const number = this.number++ >>> 0;
    if (!this.isPageThere() || this.socket.bufferedAmount > this.rate * 2 * MAX_BUFFERED) return;
    const block = new Uint8Array(HEADER + samples.byteLength);
    const header = new DataView(block.buffer);
    header.setUint32(0, number, true);
    header.setFloat64(8, heard, true);
    block.set(new Uint8Array(samples.buffer), HEADER);
    this.socket.send(block);
  }
}
