// Asks before this page takes over from the one that drives.
import { byId, setText } from "./dom.js";

export class TakeOver {
  // `confirmed` is called once somebody has said yes.
  constructor(confirmed) {
    byId("take-over-yes").onclick = () => {
      byId("take-over").close();
      confirmed();
    };
    byId("take-over-no").onclick = () => byId("take-over").close();
  }

  ask(driver) {
    setText("take-over-text", `${driver}, drives. Take over? The robot stops.`);
    byId("take-over").showModal();
  }

  close() {
    byId("take-over").close();
  }
}
