// Plays what was heard, and marks what was really said.
import { text } from "./texts.js";

const MAX_MARKABLE = 100; // utterances: more than the page shows

function element(name, shown, more = {}) {
  const made = Object.assign(document.createElement(name), more);
  if (shown !== undefined) made.textContent = shown;
  return made;
}

function button(word, press) {
  return element("button", word, { type: "button", onclick: press });
}

// A mark in words; undefined is no mark.
function markText(said, event) {
  if (said === undefined) return text("play it, or mark what it was");
  if (said === "") return text("marked: no command");
  return said === event.text ? text("marked: right") : text("marked: “{said}” was said", { said });
}

export class RecordingMarks {
  // `post` sends a request as the driving page, `showError` shows a line.
  constructor(post, player, showError) {
    this.post = post;
    this.player = player;
    this.showError = showError;
    this.commands = []; // that may have been said
    this.recordings = new Map(); // by where their utterances begin
    this.shown = new Map(); // the tools of utterances, by the same
    this.enabled = false;
  }

  fill(recordings) {
    this.recordings.clear();
    this.shown.clear();
    for (const record of recordings) this.add(record);
  }

  add(record) {
    keep(this.recordings, record.start, record);
    this.shown.get(record.start)?.show(record);
  }

  // Only the page that drives may play and mark.
  enable(on) {
    if (this.enabled === on) return;
    this.enabled = on;
    for (const tools of this.shown.values()) tools.enable();
  }

  // What belongs to an utterance on the page: hidden until it has a recording.
  tools(event) {
    const details = element("details", undefined, { className: "marking", hidden: true });
    details.setAttribute("aria-live", "off"); // buttons that appear are no news
    const summary = element("summary", markText(undefined, event));
    details.append(summary);
    const enable = () => {
      for (const one of details.querySelectorAll("button")) one.disabled = !this.enabled;
    };
    details.ontoggle = () => {
      if (details.children.length === 1) details.append(...this.rows(event));
      enable();
    };
    const show = (record) => {
      details.hidden = false;
      summary.textContent = markText(record.said, event);
    };
    keep(this.shown, event.start, { enable, show });
    const record = this.recordings.get(event.start);
    if (record) show(record);
    return details;
  }

  // Buttons, not a list that opens: that could stand above STOP.
  rows(event) {
    const row = element("div", undefined, { className: "row" });
    row.append(button(text("Play"), () => this.play(event)));
    if (event.text) row.append(button(text("Right"), () => this.mark(event, event.text)));
    row.append(button(text("No command"), () => this.mark(event, null)));
    const others = element("div", undefined, { className: "row" });
    others.setAttribute("role", "group");
    others.setAttribute("aria-label", text("what was said"));
    others.append(...this.choices(event).map((said) => button(said, () => this.mark(event, said))));
    return [row, element("p", text("or this was said:"), { className: "note" }), others];
  }

  // What may have been said instead: what was heard nearly as well, then all that has a button.
  choices(event) {
    const heard = [event.next_best, ...this.commands];
    return [...new Set(heard)].filter((said) => said && said !== event.text);
  }

  mark(event, said) {
    const { file } = this.recordings.get(event.start);
    return this.post("/api/mark", { file, said }).then(() => this.showError(""), (error) => this.showError(error.message));
  }

  play(event) {
    const { file } = this.recordings.get(event.start);
    const playing = this.player.play(`/api/recordings/${encodeURIComponent(file)}`);
    return playing.then(() => this.showError(""), (error) => this.showError(error.message));
  }
}

function keep(map, key, value) {
  map.set(key, value);
  if (map.size > MAX_MARKABLE) map.delete(map.keys().next().value);
}
