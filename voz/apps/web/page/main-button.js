// The one button that leads from nothing to talking: Drive, Allow microphone, Hold to talk.
import { byId, setText } from "./dom.js";
import { microphoneHelp } from "./microphone-help.js";
import { text } from "./texts.js";

// What comes next: [what it does, what it says].
function nextStep({ connected, mine, driver, microphone }) {
  if (!connected) return ["wait", "No connection"];
  if (!mine) return driver ? ["take-over", "Take over"] : ["drive", "Drive"];
  return {
    off: ["allow", "Allow microphone"],
    asking: ["wait", "Allow the microphone …"],
    refused: ["allow", "Try again"],
    opening: ["wait", "Hold to talk"],
    ready: ["talk", "Hold to talk"],
    none: ["none", ""],
  }[microphone];
}

export class MainButton {
  // `drive` and `takeOver` are called when they are asked for, `allowed` once there is a microphone,
  // `handsFree` with whether the page is.
  constructor(microphone, calls) {
    this.microphone = microphone;
    this.calls = calls;
    this.browserListens = false;
    this.permission = "off"; // or asking, refused, none
    this.button = byId("main-button");
    this.listen();
  }

  get state() {
    if (!this.browserListens) return "none";
    if (!this.microphone.isEnabled) return this.permission;
    return this.microphone.ready ? "ready" : "opening";
  }

  get isHandsFree() {
    return byId("hands-free").checked;
  }

  // `page`: whether this page is connected and drives, and which one does.
  show(page) {
    this.page = page;
    const [action, word] = nextStep({ ...page, microphone: this.state });
    this.action = action;
    this.button.dataset.action = action;
    this.button.hidden = action === "none";
    this.button.disabled = action === "wait";
    if (action !== "talk") this.button.removeAttribute("aria-pressed");
    else if (!this.button.hasAttribute("aria-pressed")) this.button.setAttribute("aria-pressed", "false");
    setText("main-button", text(this.isHeld ? "Speak …" : word));
    byId("hands-free-label").hidden = !page.mine || !["opening", "ready"].includes(this.state);
    byId("hands-free").disabled = action !== "talk";
  }

  get isHeld() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  // Ask for the microphone, once: a browser that has refused it says what to tap.
  async allow() {
    if (!this.browserListens || this.microphone.isEnabled || this.permission === "asking") return;
    this.permission = "asking";
    this.note("");
    try {
      await this.microphone.enable();
      this.calls.allowed();
    } catch (error) {
      this.permission = navigator.mediaDevices?.getUserMedia ? "refused" : "none";
      this.note(microphoneHelp(error, navigator.userAgent));
    }
    if (this.page) this.show(this.page);
  }

  note(line) {
    setText("voice-note", line);
  }

  press() {
    if (this.action === "drive") {
      this.calls.drive();
      this.allow(); // by the same touch: a browser asks only then
    } else if (this.action === "take-over") this.calls.takeOver();
    else if (this.action === "allow") this.allow();
  }

  talk(on, held = false) {
    if (on && !this.microphone.begin(held)) {
      this.note(text("The connection for your sound is not open yet."));
      return;
    }
    if (!on) this.microphone.end();
    if (this.action === "talk") this.button.setAttribute("aria-pressed", String(on));
    else this.button.removeAttribute("aria-pressed");
    if (this.page) this.show(this.page);
  }

  // The button is pressed or released; hands-free goes on.
  hold(on) {
    if (this.isHandsFree || (on && this.action !== "talk")) return;
    this.talk(on, true);
  }

  // No sound is sent any more.
  stopTalking() {
    byId("hands-free").checked = false;
    this.calls.handsFree(false);
    this.talk(false);
  }

  listen() {
    const { button } = this;
    button.onclick = () => this.press();
    button.onpointerdown = (event) => {
      if (this.action !== "talk") return;
      button.setPointerCapture(event.pointerId);
      this.hold(true);
    };
    button.onpointerup = button.onpointercancel = button.onlostpointercapture = () => this.hold(false);
    button.oncontextmenu = (event) => event.preventDefault();
    byId("hands-free").onchange = ({ target }) => {
      this.talk(target.checked);
      target.checked = this.microphone.talking && target.checked;
      this.calls.handsFree(target.checked);
    };
  }
}
