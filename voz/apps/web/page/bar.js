// The bar at the top: how the robot moves, whether it hears, who drives, and what is wrong.
import { byId, setText } from "./dom.js";
import { ICONS } from "./icons.js";
import { text, translate } from "./texts.js";
import * as words from "./words.js";

const FLOOR = -60; // dBFS at which the level is empty: a quiet room
const LOUD = -3; // dBFS above which a microphone is about to clip
const ALARMS = ["stop", "entry", "lost", "command", "wall"]; // the first that there is, is shown

export class Bar {
  constructor() {
    this.alarms = {};
    this.lastSeen = null;
    byId("notice-close").onclick = () => this.notice("");
    setInterval(() => this.showAge(), 500);
  }

  // `page` is what this page is: whether it drives, and how it hears.
  show(state, page) {
    this.lastSeen = performance.now();
    this.lastMotion = words.motion(state);
    this.fact("motion", ...this.lastMotion);
    this.fact("ear", ...words.ear(state, page));
    setText("driver", page.mine ? text("you drive") : driverOf(state));
    this.showLevel(state);
    this.alarm("wall", state.collided ? text("It hit something. Drive away from it.") : "");
  }

  fact(id, kind, word, more) {
    byId(id).dataset.kind = kind;
    setText(`${id}-word`, word);
    setText(`${id}-more`, more);
    if (id === "motion") byId("motion-arrow").setAttribute("d", ICONS[kind]);
  }

  showLevel(state) {
    const level = state.peak > 0 ? Math.max(FLOOR, 20 * Math.log10(state.peak)) : FLOOR;
    byId("peak").style.transform = `scaleX(${(1 - level / FLOOR).toFixed(3)})`;
    byId("peak").classList.toggle("loud", level > LOUD);
    const background = Math.min(0, state.background);
    byId("background").hidden = background <= FLOOR;
    byId("background").style.transform = `translateX(${((1 - background / FLOOR) * 100).toFixed(1)}%)`;
    setText("level-words", text("The room is at {level} dB; what is said should be 15 dB above.", { level: Math.round(state.background) }));
  }

  lost(reason) {
    const [, word, more] = this.lastMotion ?? [];
    const was = this.lastMotion ? text("was {motion}", { motion: `${word} ${more}`.trim().toLowerCase() }) : "";
    this.fact("motion", "unknown", text("unknown"), was);
    setText("driver", "");
    byId("ear").dataset.kind = "lost";
    this.alarm("wall", "");
    this.alarm("lost", translate(reason) || text("No connection to the robot. It stops if this page drove it."));
    this.isLost = true;
    this.showAge();
  }

  found() {
    this.isLost = false;
    this.alarm("lost", "");
  }

  showAge() {
    if (!this.isLost) return;
    const seconds = Math.round((performance.now() - this.lastSeen) / 1000);
    setText("ear-word", text("lost"));
    setText("ear-more", this.lastSeen === null ? "" : text("last seen {seconds} s ago", { seconds }));
  }

  // What is wrong by its cause; "" once it is well again.
  alarm(cause, line) {
    this.alarms[cause] = line;
    const shown = ALARMS.map((name) => this.alarms[name]).find(Boolean) ?? "";
    setText("alarm", shown);
    byId("alarm").hidden = !shown;
  }

  // What this page should know of until it is closed.
  notice(line) {
    setText("notice-text", line);
    byId("notice").hidden = !line;
  }
}

function driverOf(state) {
  const name = translate(state.driver_name ?? "");
  return name ? text("{name}, drives", { name }) : text("nobody drives");
}
