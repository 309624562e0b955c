// The microphone of this browser, on its way to the robot.

const HEADER = 16; // bytes: the number of the block, 0, and when it was heard
const TAIL = 400; // ms that are still sent when the button is let go: the end of the last word
const MOST_WAITING = 0.3; // s of sound that wait for a slow way; more is left out, and the gap is seen
const AGAIN = 1000; // ms until a way that was shut is opened again

export class Microphone {
  // `told` gets lines for people; "" when all is well. `shut` is called when the way for the sound breaks.
  constructor(told, shut) {
    this.told = told;
    this.shut = shut;
    this.talking = this.ready = false;
    this.number = 0;
  }

  get there() {
    return Boolean(this.context);
  }

  // Ask for the microphone; without an assistant that changes the sound.
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
    stream.getAudioTracks()[0].onended = () => this.told("The microphone is gone: connect it and load this page anew.");
    this.context = context;
  }

  // Open the way for its sound, with the secret of the page that drives.
  connect(secret) {
    this.disconnect();
    if (!this.context) return;
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/audio`);
    socket.onopen = () => socket.send(JSON.stringify({ type: "hello", page: secret, rate: this.context.sampleRate }));
    socket.onmessage = ({ data }) => this.take(socket, JSON.parse(data));
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.disconnect();
      this.told("The way for your sound broke. It is opened again.");
      this.shut();
      this.opening = setTimeout(() => this.connect(secret), AGAIN);
    };
    this.socket = socket;
  }

  disconnect() {
    clearTimeout(this.opening);
    this.socket?.close();
    this.socket = null;
    this.talking = this.ready = false;
  }

  take(socket, record) {
    if (record.type === "ping") {
      socket.send(JSON.stringify({ type: "pong", t: record.t, at: Date.now() }));
      this.ready = true;
    } else if (record.type === "late") {
      this.told(`Your sound came ${record.seconds.toFixed(1)} s late and was left out: say it again.`);
    }
  }

  begin() {
    clearTimeout(this.ending);
    this.context.resume();
    if (this.socket?.readyState !== WebSocket.OPEN || !this.ready) return false;
    if (!this.talking) this.socket.send('{"type":"begin"}');
    this.told("");
    return (this.talking = true);
  }

  // Let the last word out before the way is shut.
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
    if (this.socket.bufferedAmount > this.context.sampleRate * 2 * MOST_WAITING) return;
    const block = new Uint8Array(HEADER + samples.byteLength);
    const header = new DataView(block.buffer);
    header.setUint32(0, number, true);
    header.setFloat64(8, heard, true);
    block.set(new Uint8Array(samples.buffer), HEADER);
    this.socket.send(block);
  }
}
