// On the thread of the sound: blocks of 16-bit samples, each with the time when its last was heard.

const BLOCK = 0.02; // s

class Capture extends AudioWorkletProcessor {
  constructor() {
    super();
    this.begin();
    this.port.onmessage = ({ data }) => (this.listener = data); // a port of the thread that sends them
  }

  begin() {
    this.samples = new Int16Array(Math.round(sampleRate * BLOCK));
    this.filled = 0;
  }

  process([[channel]]) {
    if (!channel) return true;
    for (const sample of channel) {
      this.samples[this.filled++] = Math.max(-1, Math.min(sample, 32767 / 32768)) * 32768;
      if (this.filled === this.samples.length) {
        this.listener?.postMessage({ heard: Date.now(), samples: this.samples }, [this.samples.buffer]);
        this.begin();
      }
    }
    return true;
  }
}

registerProcessor("capture", Capture);
