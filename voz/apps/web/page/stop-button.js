// STOP: says "stopped" when zero velocity was sent, and keeps trying until it was.
import { byId, setText } from "./dom.js";
import { text } from "./texts.js";

const STOPPED_FOR = 2000; // ms that the button says so
const RETRY_DELAY = 1000; // ms until a stop that was not confirmed is sent again

export class StopButton {
  // `asked` is called at once when somebody presses it, `alarm` with what is wrong.
  constructor(connection, asked, alarm) {
    [this.connection, this.asked, this.alarm] = [connection, asked, alarm];
    const button = byId("stop");
    button.onpointerdown = (event) => event.isPrimary && this.press();
    button.onclick = (event) => event.detail === 0 && this.press(); // by Enter, or a screen reader
  }

  press() {
    this.asked();
    if (document.body.dataset.stop !== "failed") this.show("asked", text("stopping …"));
    return this.send();
  }

  // Only the last one counts: between two the robot may have been started again.
  async send() {
    clearTimeout(this.next);
    const number = (this.number = (this.number ?? 0) + 1);
    const stopped = await this.connection.stop().then(() => true, () => false);
    if (number !== this.number) return;
    if (stopped) this.confirmed();
    else this.failed();
  }

  confirmed() {
    this.show("stopped", text("stopped"));
    this.alarm("");
    this.next = setTimeout(() => this.show("", text("STOP")), STOPPED_FOR);
  }

  failed() {
    this.show("failed", text("NOT STOPPED"), text("Cut its power. This page keeps trying."));
    this.alarm(text("The robot did not confirm the stop."));
    this.next = setTimeout(() => this.send(), RETRY_DELAY);
  }

  // What the robot was sent: zero, for whatever reason, is what a stop asks for.
  sent({ linear, angular }) {
    if (linear || angular || document.body.dataset.stop !== "failed") return;
    this.number++; // what is still on its way does not matter
    clearTimeout(this.next);
    this.confirmed();
  }

  show(state, word, more = "") {
    document.body.dataset.stop = state;
    setText("stop-word", word);
    setText("stop-more", more);
  }
}
