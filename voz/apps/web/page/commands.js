// The buttons of the commands: a direction pad, and groups of the rest.
import { byId, element } from "./dom.js";
import { icon, ICONS } from "./icons.js";
import { SlotValues } from "./slot-values.js";
import { text } from "./texts.js";

const MIN_PAD = 2; // directions; fewer stand with the rest

export class Commands {
  // `give` is called with a sentence.
  constructor(give) {
    this.give = give;
  }

  // The buttons as the robot names them: text, group, place and slots of each.
  fill(buttons) {
    this.close();
    const onPad = buttons.filter(({ place }) => ICONS[place]);
    const pad = onPad.length < MIN_PAD ? [] : onPad;
    const groups = new Map();
    for (const button of buttons) {
      if (pad.includes(button)) continue;
      if (!groups.has(button.group)) groups.set(button.group, []);
      groups.get(button.group).push(button.slots ? this.opener(button) : this.button(button.text));
    }
    const parts = [...groups].map(([name, made]) => group(name, made));
    if (pad.length) parts.unshift(this.pad(pad));
    byId("commands").replaceChildren(...parts);
  }

  pad(buttons) {
    const pad = element("div", "pad");
    pad.setAttribute("role", "group");
    pad.setAttribute("aria-label", text("Drive"));
    const turns = buttons.some(({ place }) => place.startsWith("turn"));
    for (const { text: sentence, place } of buttons) {
      const made = this.button(sentence);
      made.prepend(icon(place));
      made.style.gridArea = turns ? place : place.replace("rotate", "turn");
      pad.append(made);
    }
    return pad;
  }

  button(sentence) {
    const made = element("button", "", element("span", "", sentence));
    made.type = "button";
    made.disabled = true;
    made.onclick = () => this.give(sentence);
    return made;
  }

  // A button of a template opens its values, below its group, and closes those of another.
  opener(button) {
    const made = this.button(button.text);
    made.append(element("span", "more", " …"));
    made.setAttribute("aria-expanded", "false");
    made.onclick = () => {
      const again = this.opened?.made === made;
      this.close();
      if (again) return;
      const values = new SlotValues(button, this.give);
      made.closest(".group").append(values.panel);
      made.setAttribute("aria-expanded", "true");
      made.setAttribute("aria-controls", values.panel.id);
      values.panel.scrollIntoView({ block: "nearest" });
      this.opened = { made, panel: values.panel };
    };
    return made;
  }

  close() {
    if (!this.opened) return;
    const { made, panel } = this.opened;
    this.opened = null;
    panel.remove();
    made.setAttribute("aria-expanded", "false");
    made.removeAttribute("aria-controls");
  }

  enable(on) {
    if (!on) this.close();
    for (const button of byId("commands").querySelectorAll("button")) button.disabled = !on;
  }
}

let made = 0;

function group(name, buttons) {
  const title = element("h3", "", text(name));
  title.id = `group-${made++}`;
  const chips = element("div", "chips", ...buttons);
  const whole = element("div", "group", title, chips);
  whole.setAttribute("role", "group");
  whole.setAttribute("aria-labelledby", title.id);
  return whole;
}
