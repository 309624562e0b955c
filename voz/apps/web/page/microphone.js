// The microphone of this browser, whose sound is sent to the robot.

const HEADER = 16; // bytes: the number of the block, 0, and when it was heard
const TAIL = 400; // ms that are still sent when the button is released: the end of the last word
const MAX_BUFFERED = 0.3; // s of sound that wait for a slow network; more is dropped, and the robot sees the gap
const RECONNECT_DELAY = 1000; // ms

export class Microphone {
  // `showNote` shows a line, "" when all is well. `onBroken` is called when the connection breaks.
  constructor(showNote, onBroken) {
    this.showNote = showNote;
    this.onBroken = onBroken;
    this.talking = this.ready = false;
    this.number = 0;
  }

  get isEnabled() {
    return Boolean(this.context);
  }

  // Ask for the microphone, without processing that changes the sound.
  async enable() {
    if (!navigator.mediaDevices?.getUserMedia) {
      throw new Error("This browser gives its microphone only to HTTPS or localhost: use an SSH tunnel, or --https.");
    }
    const audio = { autoGainControl: false, noiseSuppression: false, echoCancellation: false, channelCount: 1 };
    const stream = await navigator.mediaDevices.getUserMedia({ audio });
    const context = new AudioContext({ latencyHint: "interactive" }); // at its own rate: Firefox wants it so
    await context.audioWorklet.addModule("/page/capture.js");
    const capture = new AudioWorkletNode(context, "capture", { channelCount: 1, channelCountMode: "explicit" });
    capture.port.onmessage = ({ data }) => this.send(data);
    context.createMediaStreamSource(stream).connect(capture).connect(context.destination); // silence: it makes none
    stream.getAudioTracks()[0].onended = () => this.showNote("The microphone is gone: connect it and load this page anew.");
    this.context = context;
  }

  // Open the connection for the sound, with the secret of the driving page.
  connect(secret) {
    this.disconnect();
    if (!this.context) return;
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/audio`);
    socket.onopen = () => socket.send(JSON.stringify({ type: "hello", page: secret, rate: this.context.sampleRate }));
    socket.onmessage = ({ data }) => this.receive(socket, JSON.parse(data));
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.disconnect();
      this.showNote("The connection for your sound broke. It is opened again.");
      this.onBroken();
      this.opening = setTimeout(() => this.connect(secret), RECONNECT_DELAY);
    };
    this.socket = socket;
  }

  disconnect() {
    clearTimeout(this.opening);
    this.socket?.close();
    this.socket = null;
    this.talking = this.ready = false;
  }

  receive(socket, record) {
    if (record.type === "ping") {
      socket.send(JSON.stringify({ type: "pong", t: record.t, at: Date.now() }));
      this.ready = true;
    } else if (record.type === "late") {
      this.showNote(`Your sound came ${record.seconds.toFixed(1)} s late and was dropped: say it again.`);
    }
  }

  begin() {
    clearTimeout(this.ending);
    this.context.resume();
    if (this.socket?.readyState !== WebSocket.OPEN || !this.ready) return false;
    if (!this.talking) this.socket.send('{"type":"begin"}');
    this.showNote("");
    return (this.talking = true);
  }

  // The last word is still sent.
  end() {
    clearTimeout(this.ending);
    this.ending = setTimeout(() => {
      if (this.talking && this.socket?.readyState === WebSocket.OPEN) this.socket.send('{"type":"end"}');
      this.talking = false;
    }, TAIL);
  }

  send({ heard, samples }) {
    if (!this.talking || this.socket?.readyState !== WebSocket.OPEN) return;
    const number = this.number++ >>> 0;
    if (this.socket.bufferedAmount > this.context.sampleRate * 2 * MAX_BUFFERED) return;
    const block = new Uint8Array(HEADER + samples.byteLength);
    const header = new DataView(block.buffer);
    header.setUint32(0, number, true);
    header.setFloat64(8, heard, true);
    block.set(new Uint8Array(samples.buffer), HEADER);
    this.socket.send(block);
  }
}
