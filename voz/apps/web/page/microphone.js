// The microphone of this browser, whose sound goes to the robot from thread to thread, past the page.
import { link } from "./link.js";
import { text } from "./texts.js";

export class Microphone {
  // `showNote` shows a line, "" when all is well. `onBroken` is called when the connection breaks.
  constructor(showNote, onBroken) {
    this.showNote = showNote;
    this.onBroken = onBroken;
    this.talking = this.ready = false;
    this.noted = false; // whether the line is about the connection
    this.number = 0; // of the connection: what is still told of an older one does not count
    link.addEventListener("message", ({ data }) => this.receive(data));
  }

  get isEnabled() {
    return Boolean(this.context);
  }

  // Ask for the microphone, without processing that changes the sound.
  async enable() {
    if (!navigator.mediaDevices?.getUserMedia) {
      throw new Error(text("This browser gives its microphone only to HTTPS or localhost: use an SSH tunnel, or --https."));
    }
    const audio = { autoGainControl: false, noiseSuppression: false, echoCancellation: false, channelCount: 1 };
    const stream = await navigator.mediaDevices.getUserMedia({ audio });
    const context = new AudioContext({ latencyHint: "interactive" }); // at its own rate: Firefox wants it so
    await context.audioWorklet.addModule("/page/capture.js");
    const capture = new AudioWorkletNode(context, "capture", { channelCount: 1, channelCountMode: "explicit" });
    const { port1, port2 } = new MessageChannel();
    capture.port.postMessage(port1, [port1]);
    link.postMessage({ type: "microphone", port: port2, rate: context.sampleRate }, [port2]);
    context.createMediaStreamSource(stream).connect(capture).connect(context.destination); // silence: it makes none
    stream.getAudioTracks()[0].onended = () => this.note(text("The microphone is gone: connect it and load this page anew."), false);
    this.context = context;
  }

  // Open the connection for the sound, with the secret of the driving page.
  connect(secret) {
    this.talking = this.ready = false;
    link.postMessage({ type: "connect", secret, number: ++this.number });
  }

  // A page that drives no more needs no sound: the robot breaks the connection itself.
  disconnect() {
    if (this.noted) this.note("", false);
    this.talking = this.ready = false;
    this.number++;
    link.postMessage({ type: "disconnect" });
  }

  note(line, isOfConnection = true) {
    this.noted = isOfConnection;
    this.showNote(line);
  }

  receive(message) {
    if (message.connection !== this.number) return;
    if (message.type === "sound-ready") {
      this.ready = true;
    } else if (message.type === "sound-broken") {
      this.talking = this.ready = false;
      this.note(text("The connection for your sound broke. It is opened again."));
      this.onBroken();
    } else if (message.type === "sound-late") {
      const seconds = message.seconds.toFixed(1);
      this.note(text("Your sound came {seconds} s late and was dropped: say it again.", { seconds }));
    }
  }

  // `held`: for as long as the button is held, so what is said needs no name before it.
  begin(held) {
    this.context.resume();
    if (!this.ready) return false;
    link.postMessage({ type: "begin", held });
    this.note("", false);
    return (this.talking = true);
  }

  // The last word is still sent.
  end() {
    this.talking = false;
    link.postMessage({ type: "end" });
  }
}
