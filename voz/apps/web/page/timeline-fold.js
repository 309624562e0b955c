// Time with what is idle folded: pure. All times are s.

const IDLE = 4; // without anything from which time is folded
const FOLDED = 1; // that such a stretch takes then
const MARGIN = 1; // around what happens that stay as they are
const REPLY = 2; // that a reply takes

// The stretches in which something happens, [from, to], in order and apart.
function activeStretches({ begin, end, states, events }) {
  const stretches = [[begin, begin], [end, end]];
  for (const event of events) {
    const until = event.type === "reply" ? event.t + REPLY : event.t;
    stretches.push([Math.min(event.start ?? event.t, event.t) - MARGIN, until + MARGIN]);
  }
  states.forEach(([t, , , , linear, angular], number) => {
    if (linear || angular) stretches.push([t, states[number + 1]?.[0] ?? end]);
  });
  stretches.sort((one, other) => one[0] - other[0]);
  const apart = [];
  for (const [from, to] of stretches) {
    const last = apart.at(-1);
    if (last && from - last[1] < IDLE) last[1] = Math.max(last[1], to);
    else apart.push([from, to]);
  }
  return apart.map(([from, to]) => [Math.max(begin, from), Math.min(end, to)]);
}

export class Fold {
  // `isFolded`: whether idle stretches are.
  constructor(session, isFolded) {
    this.pieces = [];
    this.length = 0; // of all, with what is folded
    let at = session.begin;
    const stretches = isFolded ? activeStretches(session) : [[session.begin, session.end]];
    for (const [from, to] of stretches) {
      if (from > at) this.add(at, from, FOLDED, true);
      this.add(from, to, to - from, false);
      at = to;
    }
  }

  add(from, to, length, idle) {
    this.pieces.push({ from, to, begin: this.length, end: this.length + length, idle });
    this.length += length;
  }

  // Where a time of the session is, from 0 to `length`.
  place(time) {
    const piece = this.pieces.find(({ to }) => time <= to) ?? this.pieces.at(-1);
    const share = piece.to > piece.from ? (time - piece.from) / (piece.to - piece.from) : 0;
    return piece.begin + Math.max(0, share) * (piece.end - piece.begin);
  }

  // The time of the session at such a place.
  time(place) {
    const piece = this.pieces.find(({ end }) => place <= end) ?? this.pieces.at(-1);
    const share = piece.end > piece.begin ? (place - piece.begin) / (piece.end - piece.begin) : 0;
    return piece.from + Math.min(1, Math.max(0, share)) * (piece.to - piece.from);
  }
}
