// On the link's thread: the sound of a track as it is captured. An AudioContext, which other browsers need, waits
// for its loudspeaker: that makes the same sound 60 to 120 ms later.

const BLOCK = 0.02; // s
const PUNCTUAL = 50; // ms that a chunk may come later than the earliest
const PAUSE = 1500; // ms of sound that is late, after which the microphone is taken to have paused
const DRIFT = 0.001; // of the time, by which the clock of a microphone may be slow

// How old sound is that waited while this thread was busy: then chunks come faster than they were captured.
export class CaptureClock {
  constructor() {
    this.captured = this.late = 0; // ms of sound: in all, and since a chunk was punctual
    this.least = Infinity; // the least time that a chunk came behind the sound captured, ms
  }

  // Returns the age of a chunk that comes `now`, ms.
  age(now, duration) {
    this.captured += duration;
    const behind = now - this.captured;
    this.least = Math.min(this.least + DRIFT * duration, behind);
    if (behind - this.least < PUNCTUAL) this.late = 0;
    else this.late += duration;
    if (this.late > PAUSE) [this.least, this.late] = [behind, 0];
    return behind - this.least;
  }
}

// Read a stream of AudioData to its end. `onRate` is called when the sample rate is known, or another, Hz, and
// `onBlock` with blocks of 16-bit samples, each with the time when its last was heard.
export async function readTrack(stream, onRate, onBlock) {
  const reader = stream.getReader();
  const clock = new CaptureClock();
  let rate = 0;
  let waiting = []; // samples of the next block
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    if (value.sampleRate !== rate) onRate((rate = value.sampleRate));
    const age = clock.age(performance.now(), value.duration / 1000);
    waiting.push(...mono(value));
    value.close();
    if (waiting.length < rate * BLOCK) continue;
    const samples = Int16Array.from(waiting, (sample) => Math.max(-1, Math.min(sample, 32767 / 32768)) * 32768);
    onBlock({ heard: Date.now() - age, samples });
    waiting = [];
  }
}

// The mean of all channels.
function mono(data) {
  const sum = new Float32Array(data.numberOfFrames);
  const channel = new Float32Array(data.numberOfFrames);
  for (let planeIndex = 0; planeIndex < data.numberOfChannels; planeIndex++) {
    data.copyTo(channel, { planeIndex, format: "f32-planar" });
    for (let at = 0; at < sum.length; at++) sum[at] += channel[at] / data.numberOfChannels;
  }
  return sum;
}
