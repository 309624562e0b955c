// Plays what was heard, and tells the test set what it really was.

const MOST = 100; // utterances that can be marked: more than the page shows

function element(name, text, more = {}) {
  const made = Object.assign(document.createElement(name), more);
  if (text !== undefined) made.textContent = text;
  return made;
}

function button(text, press) {
  return element("button", text, { type: "button", onclick: press });
}

// What was really said, in words; undefined is that nobody has told it yet.
function told(said, event) {
  if (said === undefined) return "play it, or mark what it was";
  if (said === "") return "marked: no command";
  return said === event.text ? "marked: right" : `marked: “${said}” was said`;
}

export class Marking {
  // `ask` sends something to an address as the page that drives, `failed` gets lines for people.
  constructor(ask, player, failed) {
    this.ask = ask;
    this.player = player;
    this.failed = failed;
    this.recordings = new Map(); // by where their utterances begin
    this.shown = new Map(); // the tools of utterances, by the same
    this.allowed = false;
  }

  fill(recordings, commands) {
    this.commands = commands;
    this.recordings.clear();
    this.shown.clear();
    for (const record of recordings) this.add(record);
  }

  add(record) {
    keep(this.recordings, record.start, record);
    this.shown.get(record.start)?.show(record);
  }

  // Only the page that drives may play and mark.
  allow(on) {
    if (this.allowed === on) return;
    this.allowed = on;
    for (const tools of this.shown.values()) tools.allow();
  }

  // What belongs to an utterance on the page: hidden until it has a recording.
  tools(event) {
    const details = element("details", undefined, { className: "marking", hidden: true });
    details.setAttribute("aria-live", "off"); // buttons that appear are no news
    const summary = element("summary", told(undefined, event));
    const row = this.row(event);
    details.append(summary, row);
    const allow = () => {
      for (const one of row.children) one.disabled = !this.allowed;
    };
    const show = (record) => {
      details.hidden = false;
      summary.textContent = told(record.said, event);
    };
    allow();
    keep(this.shown, event.start, { allow, show });
    const record = this.recordings.get(event.start);
    if (record) show(record);
    return details;
  }

  row(event) {
    const row = element("div", undefined, { className: "row" });
    const said = this.choice(event);
    row.append(button("Play", () => this.play(event)));
    if (event.text) row.append(button("Right", () => this.mark(event, event.text)));
    row.append(button("No command", () => this.mark(event, null)), said);
    row.append(button("Was said", () => this.mark(event, said.value)));
    return row;
  }

  // What may have been said instead: what was heard nearly as well, then all that has a button.
  choice(event) {
    const heard = [event.next_best, ...this.commands];
    const texts = [...new Set(heard)].filter((text) => text && text !== event.text);
    const select = element("select");
    select.setAttribute("aria-label", "what was said");
    select.append(...texts.map((text) => element("option", text)));
    return select;
  }

  mark(event, said) {
    const { file } = this.recordings.get(event.start);
    return this.ask("/api/mark", { file, said }).then(() => this.failed(""), (error) => this.failed(error.message));
  }

  play(event) {
    const { file } = this.recordings.get(event.start);
    const playing = this.player.play(`/api/recordings/${encodeURIComponent(file)}`);
    return playing.then(() => this.failed(""), (error) => this.failed(error.message));
  }
}

function keep(map, key, value) {
  map.set(key, value);
  if (map.size > MOST) map.delete(map.keys().next().value);
}
