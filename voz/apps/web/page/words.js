// What is shown, in words: pure.
import { list, quoted, text, translate } from "./texts.js";

export const percent = (share, decimals = 0) => `${(share * 100).toFixed(decimals)} %`;

// Two decimals with a real minus sign, and never "-0.00".
export function velocity(value) {
  const shown = Math.abs(value) < 0.005 ? "0.00" : Math.abs(value).toFixed(2);
  return value <= -0.005 ? `\u2212${shown}` : shown;
}

export function arm(selected) {
  if (selected === 1) return text("points at the beer");
  if (selected === 2) return text("points at the cocacola");
  return selected === 100 ? text("folded") : "–";
}

export function place([x, y, heading]) {
  const degrees = Math.round((heading * 180) / Math.PI);
  return `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m, ${degrees}\u00b0`;
}

const side = (angular) => (angular > 0 ? "left" : "right");

function turning(speed, angular) {
  return angular > 0 ? text("{speed}, turning left", { speed }) : text("{speed}, turning right", { speed });
}

function rotating(angular) {
  const speed = `${velocity(Math.abs(angular))} rad/s`;
  return angular > 0 ? text("left, {speed}", { speed }) : text("right, {speed}", { speed });
}

// How the robot moves: [kind, word, more]; the kind is that of an icon.
export function motion({ linear, angular, rehearsing }) {
  const turns = Math.abs(angular) >= 0.005;
  if (Math.abs(linear) >= 0.005) {
    const [kind, word] = linear > 0 ? ["forward", text("FORWARD")] : ["back", text("BACK")];
    const speed = `${velocity(Math.abs(linear))} m/s`;
    return [turns && linear > 0 ? `turn-${side(angular)}` : kind, word, turns ? turning(speed, angular) : speed];
  }
  if (turns) return [`rotate-${side(angular)}`, text("ROTATING"), rotating(angular)];
  return rehearsing ? ["standing", text("REHEARSAL"), text("nothing moves")] : ["standing", text("STANDING"), ""];
}

// What wakes the robot: its name, the command that begins the listening, or both.
const wakingWords = ({ asleep, listening }, wake) => [asleep, listening ? "" : wake].filter(Boolean).join(", ");

// Whether somebody is heard, and why not: [kind, word, more].
export function ear(state, { mine, browserListens, microphoneOn, wake }) {
  const nobodySpeaks = browserListens && !state.driver;
  if (state.deaf && !nobodySpeaks) return ["deaf", text("deaf"), translate(state.deaf)];
  if (browserListens && !mine) return ["off", state.driver ? text("watching") : text("microphone off"), ""];
  if (state.speaking) return ["waiting", text("robot speaks"), text("hears only stop")];
  if (browserListens && !microphoneOn) return ["off", text("microphone off"), ""];
  const words = wakingWords(state, wake);
  if (words) return ["waiting", text("asleep"), state.talking ? text("hears you: say “{words}”", { words }) : text("say “{words}”", { words })];
  if (!state.listening) return ["off", text("not listening"), ""]; // and nothing of the list begins it
  if (!browserListens) return ["hearing", text("listening"), text("robot's microphone")];
  return state.talking ? ["hearing", text("hearing you"), ""] : ["ready", text("hold to talk"), ""];
}

// What to do where nothing was heard yet.
export function hint(state, mine, wake) {
  if (state.driver && !mine) return text("You watch {name}.", { name: translate(state.driver_name) });
  if (!mine) return text("Touch Drive to begin.");
  const words = wakingWords(state, wake);
  return words ? text("Say “{words}” first, or tap a command.", { words }) : text("Say a command, or tap one.");
}

// Whether what is said is recorded.
export function recording(note) {
  if (note === null) return text("To play and mark what was heard, start voz run --web --record DIR.");
  return translate(note) || text("Nothing is recorded any more.");
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
  if (["not_listening", "asleep"].includes(event.ignored)) return ["asleep", event.text, text("it is asleep")];
  if (event.accepted) return ["ignored", event.text, text(IGNORED[event.ignored] ?? "") || why(event)];
  if (!isSpoken(event)) return ["nothing", event.text, why(event)];
  if (event.between) return ["unsure", list("{one} or {other}", event.between), text("not sure which")];
  if (event.text && event.confidence >= PLAUSIBLE) return ["unsure", event.text, text("not sure enough")];
  return ["nothing", text("no command"), text(NOTHING[event.reason] ?? "somebody spoke")];
}

const why = (event) => translate(event.why ?? "");

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
  if (!isSpoken(event)) return [text("It was tapped or typed.")];
  const needs = event.needed ? ` ${text("A command needs {share}.", { share: percent(event.needed) })}` : "";
  const sentences = [text("It was {share} sure.", { share: percent(event.confidence) }) + needs];
  if (event.next_best) sentences.push(text("It might also have been {command}.", { command: quoted(event.next_best) }));
  return sentences;
}
