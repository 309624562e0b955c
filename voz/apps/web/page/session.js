// A session that was kept, at the time of a slider; it plays as fast as it was.
import { Log } from "./log.js";
import { Room } from "./room.js";
import * as words from "./words.js";

const MOST_SHOWN = 40; // of what was heard and said
const JUMP = 5; // s by which Page Up and Page Down move

const at = (id) => document.getElementById(id);
const log = new Log(at("log"), () => "");
const room = new Room(at("room"), null);
let session = null;
let now = 0; // s
let shown = { state: -1, events: -1 }; // how many of them
let playing = null; // when it began to play, ms, and from which time on, s

function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// How many of what is in order of time were until now.
function until(items, timeOf) {
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
  put(at("clock"), words);
  at("time").value = now;
  at("time").setAttribute("aria-valuetext", words);
  showState(until(session.states, ([t]) => t));
  showEvents(until(session.events, (event) => event.t));
}

function showState(count) {
  if (shown.state === count) return;
  shown.state = count;
  const [, x, y, heading, linear, angular, selected] = session.states[Math.max(0, count - 1)];
  room.show({ pose: [x, y, heading] });
  room.trace(session.states.slice(0, count).map((state) => [state[1], state[2]]));
  put(at("linear"), words.velocity(linear));
  put(at("angular"), words.velocity(angular));
  put(at("arm"), words.arm(selected));
  put(at("place"), words.place([x, y, heading]));
}

function showEvents(count) {
  if (shown.events === count) return;
  shown.events = count;
  log.fill(session.events.slice(Math.max(0, count - MOST_SHOWN), count));
}

function go(to) {
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
  put(at("play"), on ? "Pause" : "Play");
  if (on) requestAnimationFrame(step);
}

at("play").onclick = () => play(!playing);
at("time").oninput = ({ target }) => go(Number(target.value));
at("time").onkeydown = (event) => {
  const by = { PageUp: JUMP, PageDown: -JUMP }[event.key];
  if (!by) return;
  event.preventDefault();
  go(now + by);
};

const answer = await fetch("/api/session");
session = await answer.json();
now = session.begin;
if (!session.states.length) session.states = [[session.begin, 0, 0, 0, 0, 0, null]];
[at("time").min, at("time").max] = [session.begin, session.end];
at("time").disabled = at("play").disabled = false;
put(at("name"), session.name);
show();
