// What was heard, said and warned of, the newest first.
import { element } from "./dom.js";
import { text, translate } from "./texts.js";
import { isSpoken, opinion, utterance } from "./words.js";

const MAX_ENTRIES = 40;

// The confidence, with a mark at the one that is needed.
function gauge(event) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 100 4");
  svg.setAttribute("preserveAspectRatio", "none");
  svg.setAttribute("aria-hidden", "true");
  const bars = [["gauge-back", 0, 100], ["gauge", 0, event.confidence * 100]];
  if (event.needed) bars.push(["gauge-need", event.needed * 100 - 0.4, 0.8]);
  for (const [name, x, width] of bars) {
    const bar = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    for (const [key, value] of Object.entries({ class: name, x, y: 0, width, height: 4 })) bar.setAttribute(key, value);
    svg.append(bar);
  }
  return svg;
}

// How sure it was, behind a tap.
function reasons(event) {
  const sentences = opinion(event).map((sentence) => element("p", "", sentence));
  return element("details", "opinion", element("summary", "", text("how sure?")), ...sentences, gauge(event));
}

function entry(event, tools) {
  if (event.type === "utterance") {
    const [kind, what, why] = utterance(event);
    const name = kind === "obeyed" ? "obeyed" : "refused";
    const made = element("div", `entry ${name}`, element("p", "what", kind === "unsure" ? `${what}?` : what));
    if (why) made.append(element("p", "more", why));
    if (isSpoken(event)) made.append(reasons(event), tools(event));
    return made;
  }
  const kind = event.type === "reply" ? "reply" : event.good ? "good" : "warning";
  const what = event.type === "reply" ? event.text : translate(event.text);
  const made = element("div", `entry ${kind}`, element("p", "what", what));
  if (event.type === "reply") made.append(element("p", "more", text("the robot says")));
  return made;
}

const SAME_STOP = 1; // s between two stops that are one: it is sent twice

export class EventLog {
  // `tools` makes the buttons of a spoken utterance.
  constructor(list, tools) {
    this.list = list;
    this.tools = tools;
  }

  fill(events) {
    this.list.replaceChildren(...events.map((event) => entry(event, this.tools)).reverse());
  }

  add(event) {
    if (this.isSameStop(event)) return;
    this.last = event;
    this.list.prepend(entry(event, this.tools));
    while (this.list.children.length > MAX_ENTRIES) this.list.lastElementChild.remove();
  }

  isSameStop(event) {
    const last = this.last;
    const stops = (one) => one?.type === "utterance" && one.source === "page" && one.text === "stop";
    return stops(event) && stops(last) && event.t - last.t < SAME_STOP;
  }
}
