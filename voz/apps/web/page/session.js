// A recorded session at any time of it; it plays at a speed of one's choice.
import { byId, element, setText } from "./dom.js";
import { EventLog } from "./event-log.js";
import { Room } from "./room.js";
import { SessionSound } from "./session-sound.js";
import { text } from "./texts.js";
import { Fold } from "./timeline-fold.js";
import { Timeline } from "./timeline.js";
import * as words from "./words.js";

const MAX_SHOWN = 40; // events
const JUMP = 5; // s by which Page Up and Page Down move
const SAME_TIME = 0.05; // s: nearer than this, it is what was jumped to before

const session = await (await fetch("/api/session")).json();
if (!session.states.length) session.states = [[session.begin, 0, 0, 0, 0, 0, null]];
const said = session.events.filter(({ type }) => type === "utterance").map((event) => event.start);
const sound = new SessionSound();
const log = new EventLog(byId("log"), listenButton);
const room = new Room(byId("room"), session.room);
const timeline = new Timeline(byId("timeline"), session, jumpTo);
let fold = null;
let now = session.begin; // s
let shown = { state: -1, events: -1 }; // counts
let playing = null; // when it began to play, ms, and from which place of the timeline, s

const speed = () => Number(byId("speed").value);

function listenButton(event) {
  if (!event.sound) return "";
  const button = element("button", "listen", text("Listen"));
  button.type = "button";
  button.onclick = () => sound.play(event);
  return button;
}

// How many items, in order of time, are not later than now.
function countUntilNow(items, timeOf) {
  let [low, high] = [0, items.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeOf(items[middle]) <= now) low = middle + 1;
    else high = middle;
  }
  return low;
}

function show() {
  const [at, end] = [now, session.end].map((time) => (time - session.begin).toFixed(1));
  const clock = text("{at} s of {end} s", { at, end });
  setText("clock", clock);
  byId("time").value = fold.place(now);
  byId("time").setAttribute("aria-valuetext", clock);
  timeline.moveTo(now);
  showState(countUntilNow(session.states, ([t]) => t));
  showEvents(countUntilNow(session.events, (event) => event.t));
}

function showState(count) {
  if (shown.state === count) return;
  shown.state = count;
  const [, x, y, heading, linear, angular, selected, arm, collided] = session.states[Math.max(0, count - 1)];
  room.show({ pose: [x, y, heading], arm, collided });
  room.setPath(session.states.slice(0, count).map((state) => [state[1], state[2]]));
  setText("linear", words.velocity(linear));
  setText("angular", words.velocity(angular));
  setText("arm", words.arm(selected));
  setText("place", words.place([x, y, heading]));
}

function showEvents(count) {
  if (shown.events === count) return;
  shown.events = count;
  log.fill(session.events.slice(Math.max(0, count - MAX_SHOWN), count));
}

function jumpTo(to) {
  sound.stop();
  now = Math.min(session.end, Math.max(session.begin, to));
  if (playing) playing = { since: performance.now(), from: fold.place(now) };
  show();
}

// To what was said before (-1) or next (1).
function jumpToSaid(direction) {
  const apart = said.filter((start) => direction * (start - now) > SAME_TIME);
  if (apart.length) jumpTo(direction < 0 ? apart.at(-1) : apart[0]);
}

function step() {
  if (!playing) return;
  const before = now;
  const place = playing.from + (speed() * (performance.now() - playing.since)) / 1000;
  now = place < fold.length ? fold.time(place) : session.end;
  if (byId("sound").checked) sound.pass(session.events, before, now, speed());
  show();
  if (now >= session.end) play(false, false);
  else requestAnimationFrame(step);
}

// The last sound is heard to its end when it is over.
function play(on, silence = true) {
  if (on && now >= session.end) now = session.begin;
  playing = on ? { since: performance.now(), from: fold.place(now) } : null;
  setText("play", on ? text("Pause") : text("Play"));
  if (on) requestAnimationFrame(step);
  else if (silence) sound.stop();
}

function foldTime() {
  fold = new Fold(session, byId("fold").checked);
  byId("time").max = Math.ceil(fold.length * 10) / 10; // a slider ends at a whole step
  timeline.show(fold);
  jumpTo(now);
}

byId("play").onclick = () => play(!playing);
byId("previous").onclick = () => jumpToSaid(-1);
byId("next").onclick = () => jumpToSaid(1);
byId("fold").onchange = foldTime;
byId("sound").onchange = () => byId("sound").checked || sound.stop();
byId("speed").onchange = () => {
  if (playing) playing = { since: performance.now(), from: fold.place(now) };
  sound.setSpeed(speed());
};
byId("time").oninput = ({ target }) => jumpTo(fold.time(Number(target.value)));
byId("time").onkeydown = (event) => {
  const by = { PageUp: JUMP, PageDown: -JUMP }[event.key];
  if (!by) return;
  event.preventDefault();
  jumpTo(now + by);
};

byId("reckoned").hidden = Boolean(session.room);
byId("sound-label").hidden = !session.events.some((event) => event.sound);
for (const control of ["time", "play", "previous", "next"]) byId(control).disabled = false;
setText("name", session.name);
foldTime();
