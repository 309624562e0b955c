// Plays sounds of the robot, one after the other.
import { text } from "./texts.js";

const MAX_QUEUED = 3; // sounds: later ones would come too late

export class Player {
  // `post` sends a request as the driving page: only that one may play.
  constructor(post) {
    this.post = post;
    this.audio = new Audio();
    this.enabled = false;
    this.queued = 0;
    this.last = Promise.resolve();
  }

  enable(on) {
    this.enabled = on;
    if (!on && !this.audio.paused) this.audio.pause();
  }

  // The promise resolves when the sound is over. While it plays a `reply`, which the robot knows, commands are heard.
  play(address, reply = null) {
    if (this.queued >= MAX_QUEUED) return Promise.resolve();
    this.queued++;
    const turn = this.last.then(() => this.playOne(address, reply)).finally(() => this.queued--);
    this.last = turn.catch(() => {});
    return turn;
  }

  // It begins once the robot has confirmed that it knows: a microphone may be near.
  async playOne(address, reply) {
    await this.load(address);
    await this.post("/api/sounding", { seconds: this.audio.duration, reply });
    if (!this.enabled) return;
    const over = new Promise((resolve) => {
      this.audio.onended = this.audio.onpause = this.audio.onerror = resolve;
    });
    await this.audio.play();
    await over;
  }

  async load(address) {
    await new Promise((resolve, reject) => {
      this.audio.oncanplaythrough = resolve;
      this.audio.onerror = () => reject(new Error(text("That sound cannot be played: it may be gone.")));
      this.audio.src = address;
    });
  }
}
