// What may be said in the slots of a command: chips for words, a slider for numbers, and the sentence
// that they make, which is shown before it is given.
import { element } from "./dom.js";
import { text } from "./texts.js";

let made = 0;

export class SlotValues {
  // `give` is called with a sentence; `button` has its first one as `text`, and its `slots`.
  constructor(button, give) {
    this.words = button.text.split(" ");
    this.slots = button.slots;
    this.chosen = new Map();
    this.sentence = element("p", "sentence");
    this.sentence.setAttribute("aria-live", "polite");
    const send = element("button", "primary", text("Say it"));
    send.type = "button";
    send.onclick = () => give(this.text());
    const choices = this.slots.map((slot) => this.choice(slot));
    this.sentence.textContent = this.text();
    this.panel = element("div", "values", ...choices, this.sentence, send);
    this.panel.id = `values-${made++}`;
    this.panel.setAttribute("role", "group");
    this.panel.setAttribute("aria-label", text("What to say: {text}", { text: button.text }));
  }

  // The sentence with what was chosen, the last slot first, for the places of the words.
  text() {
    const words = [...this.words];
    for (const slot of [...this.slots].reverse()) {
      if (this.chosen.has(slot)) words.splice(slot.start, slot.end - slot.start, this.chosen.get(slot));
    }
    return words.join(" ");
  }

  choose(slot, value) {
    this.chosen.set(slot, value);
    this.sentence.textContent = this.text();
  }

  choice(slot) {
    return slot.is_number ? this.slider(slot) : this.chips(slot);
  }

  slider(slot) {
    const { name, values } = slot;
    const output = element("output", "", values[0]);
    const range = element("input");
    Object.assign(range, { type: "range", min: 0, max: values.length - 1, step: 1, value: 0 });
    range.setAttribute("aria-valuetext", values[0]);
    range.oninput = () => {
      const value = values[range.value];
      output.textContent = value;
      range.setAttribute("aria-valuetext", value);
      this.choose(slot, value);
    };
    this.chosen.set(slot, values[0]);
    return element("label", "slider", element("span", "", name), range, output);
  }

  chips(slot) {
    const first = this.words.slice(slot.start, slot.end).join(" ");
    const chips = slot.values.map((value) => {
      const chip = element("button", "", value);
      chip.type = "button";
      chip.setAttribute("aria-pressed", String(value === first));
      chip.onclick = () => {
        for (const each of chips) each.setAttribute("aria-pressed", String(each === chip));
        this.choose(slot, value);
      };
      return chip;
    });
    const group = element("div", "chips", ...chips);
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", slot.name);
    return group;
  }
}
