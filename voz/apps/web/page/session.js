// A recorded session at the time of a slider; it plays at its own speed.
import { EventLog } from "./event-log.js";
import { Room } from "./room.js";
import * as words from "./words.js";

const MAX_SHOWN = 40; // events
const JUMP = 5; // s by which Page Up and Page Down move

const byId = (id) => document.getElementById(id);
const log = new EventLog(byId("log"), () => "");
const room = new Room(byId("room"), null);
let session = null;
let now = 0; // s
let shown = { state: -1, events: -1 }; // counts
let playing = null; // when it began to play, ms, and from which time of the session, s

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
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
  const words = `${(now - session.begin).toFixed(1)} s of ${(session.end - session.begin).toFixed(1)} s`;
  setText(byId("clock"), words);
  byId("time").value = now;
  byId("time").setAttribute("aria-valuetext", words);
  showState(countUntilNow(session.states, ([t]) => t));
  showEvents(countUntilNow(session.events, (event) => event.t));
}

function showState(count) {
  if (shown.state === count) return;
  shown.state = count;
  const [, x, y, heading, linear, angular, selected] = session.states[Math.max(0, count - 1)];
  room.show({ pose: [x, y, heading] });
  room.setPath(session.states.slice(0, count).map((state) => [state[1], state[2]]));
  setText(byId("linear"), words.velocity(linear));
  setText(byId("angular"), words.velocity(angular));
  setText(byId("arm"), words.arm(selected));
  setText(byId("place"), words.place([x, y, heading]));
}

function showEvents(count) {
  if (shown.events === count) return;
  shown.events = count;
  log.fill(session.events.slice(Math.max(0, count - MAX_SHOWN), count));
}

function jumpTo(to) {
  now = Math.min(session.end, Math.max(session.begin, to));
  if (playing) playing = { since: performance.now(), from: now };
  show();
}

function step() {
  if (!playing) return;
  now = Math.min(session.end, playing.from + (performance.now() - playing.since) / 1000);
  show();
  if (now >= session.end) play(false);
  else requestAnimationFrame(step);
}

function play(on) {
  if (on && now >= session.end) now = session.begin;
  playing = on ? { since: performance.now(), from: now } : null;
  setText(byId("play"), on ? "Pause" : "Play");
  if (on) requestAnimationFrame(step);
}

byId("play").onclick = () => play(!playing);
byId("time").oninput = ({ target }) => jumpTo(Number(target.value));
byId("time").onkeydown = (event) => {
  const by = { PageUp: JUMP, PageDown: -JUMP }[event.key];
  if (!by) return;
  event.preventDefault();
  jumpTo(now + by);
};

const answer = await fetch("/api/session");
session = await answer.json();
now = session.begin;
if (!session.states.length) session.states = [[session.begin, 0, 0, 0, 0, 0, null]];
[byId("time").min, byId("time").max] = [session.begin, session.end];
byId("time").disabled = byId("play").disabled = false;
setText(byId("name"), session.name);
show();
