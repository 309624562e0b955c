// How many false alarms there may be, and how many commands that costs.
import { percent } from "./words.js";

export class Dial {
  // `at` finds parts of the page, `ask` sends something to an address as the page that drives.
  constructor(at, ask) {
    this.at = at;
    this.slider = at("alarms");
    this.stops = [];
    this.slider.oninput = () => this.write();
    this.slider.onchange = () => this.turn(ask);
  }

  fill({ stops, problem }) {
    [this.stops, this.problem] = [stops, problem];
    this.slider.max = Math.max(0, stops.length - 1);
    this.set = null;
    this.at("alarms-known").hidden = Boolean(problem);
    this.note(problem || "");
  }

  // Where it stands; while somebody moves it only what is new moves it away.
  show(alarms) {
    if (this.set === alarms) return;
    this.set = alarms;
    this.slider.value = Math.max(0, this.stops.findIndex(([stop]) => stop >= alarms));
    this.write();
  }

  allow(on) {
    const disabled = !on || Boolean(this.problem);
    if (this.slider.disabled !== disabled) this.slider.disabled = disabled;
  }

  async turn(ask) {
    const [alarms] = this.stops[this.slider.value];
    try {
      await ask("/api/alarms", { alarms });
      this.note("");
    } catch (error) {
      this.note(error.message);
      const before = this.set;
      this.set = null;
      this.show(before);
    }
  }

  write() {
    if (this.problem) return;
    const [alarms, missed] = this.stops[this.slider.value];
    const words = `${alarms} false alarms in an hour of talk, ${percent(missed, 1)} of commands missed`;
    this.put("alarms-words", words);
    this.put("alarms-line", `[recognition]\nfalse_alarms_per_hour = ${alarms}`);
    this.slider.setAttribute("aria-valuetext", words);
  }

  note(text) {
    this.put("alarms-note", text);
  }

  put(id, text) {
    if (this.at(id).textContent !== text) this.at(id).textContent = text;
  }
}
