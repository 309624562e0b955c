// Plays sounds of the robot, one after the other.

const MOST_WAITING = 3; // what is played later no longer belongs to what was done

export class Player {
  // `ask` sends something to an address as the page that drives: only that one may play.
  constructor(ask) {
    this.ask = ask;
    this.audio = new Audio();
    this.allowed = false;
    this.waiting = 0;
    this.last = Promise.resolve();
  }

  allow(on) {
    this.allowed = on;
    if (!on && !this.audio.paused) this.audio.pause();
  }

  // The promise is kept when it is over.
  play(address) {
    if (this.waiting >= MOST_WAITING) return Promise.resolve();
    this.waiting++;
    const turn = this.last.then(() => this.sound(address)).finally(() => this.waiting--);
    this.last = turn.catch(() => {});
    return turn;
  }

  // It sounds only once the robot has said that it hears nothing but stop: a microphone may be near.
  async sound(address) {
    await this.loaded(address);
    await this.ask("/api/sounding", { seconds: this.audio.duration });
    if (!this.allowed) return;
    const over = new Promise((resolve) => {
      this.audio.onended = this.audio.onpause = this.audio.onerror = resolve;
    });
    await this.audio.play();
    await over;
  }

  async loaded(address) {
    await new Promise((resolve, reject) => {
      this.audio.oncanplaythrough = resolve;
      this.audio.onerror = () => reject(new Error("That sound cannot be played: it may be gone."));
      this.audio.src = address;
    });
  }
}
