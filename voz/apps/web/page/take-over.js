// Asks before this page takes over from the one that drives. STOP can be pressed meanwhile, as always: a modal
// dialog would stand above it.
import { byId, setText } from "./dom.js";
import { text } from "./texts.js";

export class TakeOver {
  // `confirmed` is called once somebody has said yes.
  constructor(confirmed) {
    this.dialog = byId("take-over");
    byId("take-over-yes").onclick = () => {
      this.close();
      confirmed();
    };
    byId("take-over-no").onclick = () => this.close();
    addEventListener("keydown", ({ key }) => key === "Escape" && this.close());
  }

  ask(driver) {
    setText("take-over-text", text("{name}, drives. Take over? The robot stops.", { name: driver }));
    this.dialog.show();
    this.setAside(true);
  }

  close() {
    this.setAside(false);
    this.dialog.close();
  }

  // All but the dock, where STOP is, waits for the answer.
  setAside(on) {
    for (const part of document.querySelectorAll("header, main")) part.inert = on;
  }
}
