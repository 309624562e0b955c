// What is shown, in words: pure.

export const percent = (share, decimals = 0) => `${(share * 100).toFixed(decimals)} %`;

// Two decimals with a real minus sign, and never "-0.00".
export function velocity(value) {
  const shown = Math.abs(value) < 0.005 ? "0.00" : Math.abs(value).toFixed(2);
  return value <= -0.005 ? `\u2212${shown}` : shown;
}

export function arm(selected) {
  if (selected === 1) return "points at the beer";
  if (selected === 2) return "points at the cocacola";
  return selected === 100 ? "folded" : "–";
}

export function place([x, y, heading]) {
  const degrees = Math.round((heading * 180) / Math.PI);
  return `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m, ${degrees}\u00b0`;
}

const side = (angular) => (angular > 0 ? "left" : "right");

// How the robot moves: [kind, word, more]; the kind is that of an icon.
export function motion({ linear, angular, rehearsing }) {
  const turns = Math.abs(angular) >= 0.005;
  if (Math.abs(linear) >= 0.005) {
    const [kind, word] = linear > 0 ? ["forward", "FORWARD"] : ["back", "BACK"];
    const more = `${velocity(Math.abs(linear))} m/s` + (turns ? `, turning ${side(angular)}` : "");
    return [turns && linear > 0 ? `turn-${side(angular)}` : kind, word, more];
  }
  if (turns) return [`rotate-${side(angular)}`, "ROTATING", `${side(angular)}, ${velocity(Math.abs(angular))} rad/s`];
  return rehearsing ? ["standing", "REHEARSAL", "nothing moves"] : ["standing", "STANDING", ""];
}

// Whether somebody is heard, and why not: [kind, word, more].
export function ear(state, { mine, browserListens, microphoneOn, wake }) {
  if (state.deaf) return ["deaf", "deaf", state.deaf];
  if (browserListens && !mine) return state.driver ? ["off", "watching", ""] : ["off", "microphone off", ""];
  if (state.speaking) return ["waiting", "robot speaks", "hears only stop"];
  if (browserListens && !microphoneOn) return ["off", "microphone off", ""];
  const words = [state.asleep, state.listening ? "" : wake].filter(Boolean).join(", ");
  if (words) return ["waiting", "asleep", (state.talking ? "hears you: " : "") + `say “${words}”`];
  if (!state.listening) return ["off", "not listening", ""]; // and nothing of the list begins it
  if (!browserListens) return ["hearing", "listening", "robot's microphone"];
  return state.talking ? ["hearing", "hearing you", ""] : ["ready", "hold to talk", ""];
}

// Whether what is said is recorded.
export function recording(note) {
  if (note === null) return "To play and mark what was heard, start voz run --web --record DIR.";
  return note || "Nothing is recorded any more.";
}

export const isSpoken = (event) => !["page", "program", "wyoming", "text", "bag"].includes(event.source);

const IGNORED = {
  robot_speaking: "the robot was speaking: say it again",
  too_late: "it came too late: say it again",
  not_now: "it means nothing right now",
  asked_first: "it is done after a yes",
  nothing_asked: "nothing was asked",
  rehearsal: "rehearsal: nothing moves",
};

// An utterance: [kind, what, why it was not obeyed].
export function utterance(event) {
  if (event.obeyed) return ["obeyed", event.text, ""];
  if (["not_listening", "asleep"].includes(event.ignored)) return ["asleep", event.text, "it is asleep"];
  if (event.accepted) return ["ignored", event.text, IGNORED[event.ignored] ?? event.why ?? ""];
  if (!isSpoken(event)) return ["nothing", event.text, event.why ?? ""];
  if (event.between) return ["unsure", event.between.join(" or "), "not sure which"];
  if (event.text && event.confidence >= PLAUSIBLE) return ["unsure", event.text, "not sure enough"];
  return ["nothing", "no command", NOTHING[event.reason] ?? "somebody spoke"];
}

const PLAUSIBLE = 0.2; // confidence: below it is rather talk, for which some command fits best, too

const NOTHING = {
  part_of_a_command: "only a part of one",
  too_short: "too short",
  too_quiet: "too quiet: come nearer",
  no_speech: "a noise",
};

// How sure it was of an utterance, in sentences.
export function opinion(event) {
  if (event.source === "bag") return []; // a bag has texts alone
  if (!isSpoken(event)) return ["It was tapped or typed."];
  const needs = event.needed ? ` A command needs ${percent(event.needed)}.` : "";
  const sentences = [`It was ${percent(event.confidence)} sure.${needs}`];
  if (event.next_best) sentences.push(`It might also have been “${event.next_best}”.`);
  return sentences;
}
