// What was heard last, large; what the robot was not sure of is done by a tap.
import { byId, element, setText } from "./dom.js";
import { icon } from "./icons.js";
import { text } from "./texts.js";
import { utterance } from "./words.js";

export class Heard {
  // `give` is called with a sentence.
  constructor(give) {
    this.give = give;
    this.mine = false;
    this.last = null;
    this.hint = "";
  }

  fill(events) {
    this.last = null;
    setText("reply", "");
    for (const event of events) this.add(event);
    this.draw();
  }

  add(event) {
    if (event.type === "reply") setText("reply", text("robot: {text}", { text: event.text }));
    if (event.type !== "utterance") return;
    if (this.last) setText("reply", "");
    this.last = event;
    this.draw();
  }

  // Whether this page drives, and what to do where nothing was heard yet.
  show(mine, hint) {
    if (this.mine === mine && (this.last || this.hint === hint)) return;
    [this.mine, this.hint] = [mine, hint];
    this.draw();
  }

  draw() {
    if (!this.last) {
      byId("heard").replaceChildren(element("p", "why", this.hint));
      return;
    }
    const [kind, what, why] = utterance(this.last);
    byId("heard").dataset.kind = kind;
    byId("heard").replaceChildren(...this.parts(kind, what, why));
  }

  parts(kind, what, why) {
    if (kind === "obeyed") return [element("p", "what", icon("tick"), what)];
    if (!["unsure", "asleep"].includes(kind)) return [element("p", "what", what), element("p", "why", why)];
    if (!this.mine) return [element("p", "what", `${what}?`), element("p", "why", why)];
    const texts = this.last.between ?? [this.last.text];
    const choice = text(texts.length > 1 ? "tap the right one" : kind === "asleep" ? "tap to wake it and do it" : "tap to do it");
    return [element("div", "offers", ...texts.map((one) => this.offer(one))), element("p", "why", text("{why}: {choice}", { why, choice }))];
  }

  offer(sentence) {
    const button = element("button", "what", `${sentence}?`);
    button.type = "button";
    button.onclick = () => this.give(sentence);
    return button;
  }
}
