// What the robot has asked: a button for each answer, until it is answered or forgotten.
import { byId, element, setText } from "./dom.js";
import { list, quoted, text } from "./texts.js";

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

export class Question {
  // `give` is called with an answer.
  constructor(give) {
    this.give = give;
    this.shown = "";
  }

  // `question` is that of the state, null if nothing is asked; `mine`: whether this page drives.
  show(question, mine) {
    const asked = JSON.stringify(question);
    if (asked !== this.shown) this.draw(question);
    this.shown = asked;
    for (const button of byId("answers").children) button.disabled = !mine;
  }

  // Answers that are no commands can only be said.
  draw(question) {
    byId("question").hidden = !question;
    const { text: asked = "", answers = [], commands = [] } = question ?? {};
    const said = () => text("Say {answers}.", { answers: list("{one} or {other}", answers.map(quoted)) });
    setText("question-text", question && !commands.length ? `${asked} ${said()}` : asked);
    byId("answers").replaceChildren(...commands.map((answer) => this.button(answer)));
  }

  button(answer) {
    const made = element("button", "primary", capital(answer));
    made.type = "button";
    made.onclick = () => this.give(answer);
    return made;
  }
}
