// The sound of a session: each recording of what was said, when the time comes to it.

export class SessionSound {
  constructor() {
    this.audio = new Audio();
    this.audio.preservesPitch = true;
  }

  // Time has gone on from one moment to the next, s: what begins in between is heard.
  pass(events, from, to, speed) {
    const next = events.findLast(({ sound }) => sound && from <= sound.begin && sound.begin < to);
    if (next) this.play(next, speed);
  }

  play({ sound }, speed = 1) {
    this.audio.src = `/api/recordings/${encodeURIComponent(sound.file)}`;
    this.audio.playbackRate = speed;
    this.audio.play().catch(() => {}); // a recording may be gone, and another may come at once
  }

  setSpeed(speed) {
    this.audio.playbackRate = speed;
  }

  stop() {
    this.audio.pause();
  }
}
