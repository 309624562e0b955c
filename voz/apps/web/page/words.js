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

// Whether the robot hears, and why not: [kind, words].
export function status(state) {
  if (state.deaf) return ["deaf", `deaf: ${state.deaf}`];
  if (state.rehearsing) return ["waiting", "rehearsal: nothing moves"];
  if (state.speaking) return ["speaking", "speaking: hears only stop"];
  if (!state.listening) return ["waiting", "say or tap “start speech”"];
  return ["listening", state.talking ? "listening to you" : "listening"];
}

// Whether what is said is recorded.
export function recording(note) {
  if (note === null) return "To play and mark what was heard, start voz run --web --record DIR.";
  return note || "Nothing is recorded any more.";
}

// An utterance: [kind, what, more].
export function utterance(event) {
  const typed = event.source === "page" || event.source === "text";
  const sure = `${percent(event.confidence)} sure` + (event.needed ? `, needs ${percent(event.needed)}` : "");
  const from = event.source === "bag" ? "" : typed ? "tapped or typed" : sure; // a bag has texts alone
  const details = [from, score(event)].filter(Boolean).join(" · ");
  if (event.obeyed) return ["obeyed", event.text, details];
  const what = event.accepted || typed ? event.text : event.text ? `perhaps “${event.text}”` : "something else";
  return ["refused", what, [event.why, details].filter(Boolean).join(" · ")];
}

function score(event) {
  if (event.score === undefined || event.score === null) return "";
  return `score ${event.score.toFixed(1)}` + (event.next_best ? `, next best “${event.next_best}”` : "");
}
