// What to tap where a microphone is not to be had, in the words of this browser: pure.
import { text } from "./texts.js";

export function browserOf(agent) {
  const system = /iPhone|iPad/.test(agent) ? "ios" : /Android/.test(agent) ? "android" : "desktop";
  if (/Firefox|FxiOS/.test(agent)) return `firefox ${system}`;
  if (/Chrome|CriOS|Chromium|Edg/.test(agent)) return `chrome ${system}`;
  return /Safari/.test(agent) ? `safari ${system}` : "other";
}

const ALLOW = {
  "chrome android": "Tap the icon left of the address, Permissions, Microphone, Allow.",
  "chrome desktop": "Click the icon left of the address, and switch Microphone on.",
  "chrome ios": "Open Settings, Chrome, and switch Microphone on.",
  "firefox android": "Tap the lock left of the address, and the blocked Microphone, so that it is allowed.",
  "firefox desktop": "Click the crossed-out microphone left of the address, and clear Blocked.",
  "firefox ios": "Open Settings, Firefox, and switch Microphone on.",
  "safari ios": "Tap the icon left of the address, Website Settings, Microphone, Allow.",
  "safari desktop": "Click Safari in the menu bar, Settings for This Website, Microphone, Allow.",
  other: "Allow the microphone for this page in the settings of your browser.",
};

// `error` is what the browser says of a microphone that it does not give.
export function microphoneHelp(error, agent) {
  if (error.name === "NotAllowedError") return text("The microphone is blocked. {advice} Then touch Try again.", { advice: text(ALLOW[browserOf(agent)]) });
  if (error.name === "NotFoundError") return text("This device has no microphone. Connect one, then touch Try again.");
  if (error.name === "NotReadableError") return text("Another program uses the microphone. Close it, then touch Try again.");
  return error.message;
}
