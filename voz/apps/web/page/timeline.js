// The timeline of a session: what was said and done on it, how the robot moved, and what is folded.
import { element } from "./dom.js";
import { text, translate } from "./texts.js";
import { utterance } from "./words.js";

const LANES = 3; // of texts above each other; what has no room in them has a mark alone
const BINS = 600; // along the curve of the motion
const GAP = 6; // px between two texts
const SVG = "http://www.w3.org/2000/svg";

function shape(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

// [kind, text] of an event on the timeline.
function mark(event) {
  if (event.type === "utterance") {
    const [kind, what] = utterance(event);
    return [kind === "obeyed" ? "obeyed" : "refused", kind === "unsure" ? `${what}?` : what];
  }
  if (event.type === "reply") return ["reply", ""];
  return [event.good ? "good" : "warning", ""];
}

function duration(seconds) {
  const minutes = Math.floor(seconds / 60);
  return minutes ? `${minutes} min ${Math.round(seconds - 60 * minutes)} s` : `${Math.round(seconds)} s`;
}

export class Timeline {
  // `jumpTo` is called with the time of what is tapped, s.
  constructor(box, session, jumpTo) {
    [this.box, this.session, this.jumpTo] = [box, session, jumpTo];
    this.fold = null;
    this.now = element("div", "now");
    new ResizeObserver(() => this.fold && this.draw()).observe(box);
  }

  // Draw it anew, with time folded so.
  show(fold) {
    this.fold = fold;
    this.draw();
  }

  moveTo(time) {
    this.time = time;
    this.now.style.left = this.percent(time);
  }

  percent(time) {
    return `${((100 * this.fold.place(time)) / (this.fold.length || 1)).toFixed(3)}%`;
  }

  draw() {
    this.box.replaceChildren(...this.folds(), this.motion(), ...this.marks(), this.now);
    this.placeTexts();
    for (const fold of this.box.querySelectorAll(".fold")) fold.firstChild.hidden = fold.firstChild.offsetWidth > fold.clientWidth;
    this.moveTo(this.time ?? this.session.begin);
  }

  folds() {
    return this.fold.pieces.filter(({ idle }) => idle).map(({ from, to, begin, end }) => {
      const made = element("div", "fold", element("span", "", duration(to - from)));
      made.title = text("nothing happened for {time}", { time: duration(to - from) });
      made.style.left = `${(100 * begin) / this.fold.length}%`;
      made.style.width = `${(100 * (end - begin)) / this.fold.length}%`;
      return made;
    });
  }

  // How fast the robot drove, above the middle, and turned, below it: of each the largest in a piece.
  motion() {
    const svg = shape("svg", { class: "motion", viewBox: `0 -1 ${BINS} 2`, preserveAspectRatio: "none", "aria-hidden": "true" });
    const { states } = this.session;
    for (const [column, sign] of [[4, -1], [5, 1]]) {
      const most = Math.max(0.1, ...states.map((state) => Math.abs(state[column])));
      const bins = new Float32Array(BINS);
      states.forEach((state, number) => {
        const [from, to] = [state[0], states[number + 1]?.[0] ?? this.session.end].map((t) => this.bin(t));
        const speed = Math.abs(state[column]) / most;
        for (let bin = from; speed && bin <= to; bin++) bins[bin] = Math.max(bins[bin], speed);
      });
      const top = Array.from(bins, (speed, bin) => `L${bin} ${sign * speed} H${bin + 1}`).join(" ");
      svg.append(shape("path", { class: column === 4 ? "driving" : "turning", d: `M0 0 ${top} L${BINS} 0 Z` }));
    }
    return svg;
  }

  bin(time) {
    return Math.min(BINS - 1, Math.floor((BINS * this.fold.place(time)) / (this.fold.length || 1)));
  }

  marks() {
    return this.session.events.map((event) => {
      const [kind, said] = mark(event);
      const at = event.start ?? event.t;
      const made = element("div", `mark ${kind}`, ...(said ? [element("span", "", said)] : []));
      made.title = translate(event.text) || said;
      made.style.left = this.percent(at);
      made.onclick = () => this.jumpTo(at);
      return made;
    });
  }

  // Texts go into the first lane that is free there; in a full place only marks are seen.
  placeTexts() {
    const free = new Array(LANES).fill(-Infinity);
    const { left, right } = this.box.getBoundingClientRect();
    for (const text of this.box.querySelectorAll(".mark span")) {
      const made = text.getBoundingClientRect();
      const over = Math.max(0, made.right - right);
      const begin = made.left - over - left;
      const lane = free.findIndex((end) => begin >= end);
      text.hidden = lane < 0;
      if (lane < 0) continue;
      free[lane] = made.right - over - left + GAP;
      text.style.translate = `${-over}px`;
      text.parentElement.style.setProperty("--lane", lane);
    }
  }
}
