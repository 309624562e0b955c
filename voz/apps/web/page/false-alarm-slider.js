// The slider for false_alarms_per_hour, and how many commands are missed for it.
import { text, translate } from "./texts.js";
import { percent } from "./words.js";

export class FalseAlarmSlider {
  // `byId` finds an element of the page, `post` sends a request as the driving page.
  constructor(byId, post) {
    this.byId = byId;
    this.slider = byId("alarms");
    this.stops = [];
    this.slider.oninput = () => this.showChoice();
    this.slider.onchange = () => this.send(post);
  }

  fill({ stops, problem }) {
    [this.stops, this.problem] = [stops, problem];
    this.slider.max = Math.max(0, stops.length - 1);
    this.current = null;
    this.byId("alarms-known").hidden = Boolean(problem);
    this.showNote(translate(problem || ""));
  }

  // Show the current value; only a new one moves the slider, as somebody may be moving it.
  show(alarms) {
    if (this.current === alarms) return;
    this.current = alarms;
    this.slider.value = Math.max(0, this.stops.findIndex(([stop]) => stop >= alarms));
    this.showChoice();
  }

  enable(on) {
    const disabled = !on || Boolean(this.problem);
    if (this.slider.disabled !== disabled) this.slider.disabled = disabled;
  }

  async send(post) {
    const [alarms] = this.stops[this.slider.value];
    try {
      await post("/api/alarms", { alarms });
      this.showNote("");
    } catch (error) {
      this.showNote(error.message);
      const before = this.current;
      this.current = null;
      this.show(before);
    }
  }

  showChoice() {
    if (this.problem) return;
    const [alarms, missed] = this.stops[this.slider.value];
    const cost = { alarms, share: percent(missed, 1) };
    const words = text("{alarms} false alarms in an hour of talk, {share} of commands missed", cost);
    this.setText("alarms-words", words);
    this.setText("alarms-line", `[recognition]\nfalse_alarms_per_hour = ${alarms}`);
    this.slider.setAttribute("aria-valuetext", words);
  }

  showNote(note) {
    this.setText("alarms-note", note);
  }

  setText(id, shown) {
    if (this.byId(id).textContent !== shown) this.byId(id).textContent = shown;
  }
}
