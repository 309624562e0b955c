// Puts the parts of the page together.
import { Connection } from "./connection.js";
import { Dial } from "./dial.js";
import { Log } from "./log.js";
import { Marking } from "./marking.js";
import { Microphone } from "./microphone.js";
import { Player } from "./player.js";
import { Room } from "./room.js";
import * as words from "./words.js";

const FLOOR = -60; // dBFS at which the bar is empty: a quiet room
const LOUD = -3; // dBFS above which a microphone is about to clip
const STOPPED_FOR = 2000; // ms that the button says so

const at = (id) => document.getElementById(id);
const connection = new Connection(told, lost);
const ask = (address, more) => connection.ask(address, more);
const player = new Player(ask);
const marking = new Marking(ask, player, (text) => put(at("marking-note"), text));
const dial = new Dial(at, ask);
const log = new Log(at("log"), (event) => marking.tools(event));
const microphone = new Microphone((text) => put(at("voice-note"), text), quiet);
let about = null; // what does not change, and which page this is
let state = null; // how things are
let room = null;
let wantsToDrive = false; // it drove before the way was lost
let wakeLock = null;

// Change what is shown only if it is another: nothing flickers, and nothing is read out twice.
function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function alarm(text) {
  put(at("alarm"), text);
  at("alarm").hidden = !text;
}

// A stop that was not confirmed stays in sight until one is.
function allWell() {
  if (at("stop").dataset.state !== "failed") alarm("");
}

const driving = () => Boolean(about && state && state.driver === about.page);

// What comes from the robot

function told(record) {
  if (record.type === "welcome") welcome(record);
  else if (record.type === "state") show(record);
  else if (record.type === "drive") drove(record);
  else if (record.type === "recording") marking.add(record);
  else if (["utterance", "reply", "warning"].includes(record.type)) log.add(record);
  if (record.type === "reply" && at("replies").checked && driving()) say(record.text);
}

function say(text) {
  const playing = player.play(`/api/reply?text=${encodeURIComponent(text)}`);
  playing.catch((error) => put(at("voice-note"), error.message));
}

function welcome(record) {
  about = record;
  allWell();
  room = new Room(at("room"), record.room);
  marking.fill(record.recordings, record.commands);
  dial.fill(record.tuning);
  log.fill(record.events);
  at("voice").hidden = record.microphone !== "browser";
  put(at("voice-note"), record.microphone === "browser" ? "" : `The robot listens by its own microphone, ${record.microphone}.`);
  const buttons = record.commands.filter((text) => text !== "stop").map(commandButton);
  at("commands").replaceChildren(...buttons);
  show(record.now);
  if (wantsToDrive) connection.send("drive");
}

function show(now) {
  const before = state;
  const drove = driving();
  state = now;
  room.show(now);
  const [kind, text] = words.status(now);
  at("status").dataset.kind = kind;
  put(at("status"), text);
  put(at("linear"), words.velocity(now.linear));
  put(at("angular"), words.velocity(now.angular));
  put(at("arm"), words.arm(now.selected));
  put(at("place"), words.place(now.pose));
  put(at("recording"), words.recording(now.recording));
  dial.show(now.alarms);
  showLevel(now);
  showWheel(now, before);
  if (drove && !driving()) lostWheel();
}

function showLevel(now) {
  const level = now.peak > 0 ? Math.max(FLOOR, 20 * Math.log10(now.peak)) : FLOOR;
  at("peak").style.transform = `scaleX(${(1 - level / FLOOR).toFixed(3)})`;
  at("peak").classList.toggle("loud", level > LOUD);
  const background = Math.min(0, Math.max(FLOOR, now.background));
  at("background").style.transform = `translateX(${((1 - background / FLOOR) * 100).toFixed(1)}%)`;
  put(at("level-words"), `the room is at ${Math.round(now.background)} dB`);
}

function showWheel(now, before) {
  const mine = driving();
  put(at("driver"), mine ? "you drive" : now.driver ? `${now.driver_name} drives` : "nobody drives");
  at("drive").hidden = mine;
  put(at("drive"), now.driver ? "Take over" : "Drive");
  at("leave").hidden = !mine;
  at("rehearse").disabled = !mine;
  // A tick that is still on its way to the robot is not taken away.
  if (!mine || now.rehearsing !== before?.rehearsing) at("rehearse").checked = now.rehearsing;
  for (const button of at("commands").children) button.disabled = !mine;
  allow(mine);
  at("microphone").disabled = !mine;
  at("talk").disabled = at("hands-free").disabled = !mine || !microphone.ready;
}

// What only the page that drives may do besides commands.
function allow(mine) {
  for (const part of [player, marking, dial]) part.allow(mine);
  at("replies").disabled = !mine;
}

function drove(record) {
  if (!record.driving) return;
  wantsToDrive = true;
  if (microphone.there) microphone.connect(about.secret);
}

function lostWheel() {
  wantsToDrive = false;
  quiet();
  microphone.disconnect();
}

function lost(reason) {
  at("status").dataset.kind = "lost";
  put(at("status"), "no connection");
  alarm(reason || "No connection to the robot. It stops if this page drove it.");
  quiet();
  allow(false);
  microphone.disconnect();
  state = null;
  for (const button of at("commands").children) button.disabled = true;
}

// What goes to it

function commandButton(text) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = text;
  button.disabled = true;
  button.onclick = () => connection.command(text).then(allWell, (error) => alarm(error.message));
  return button;
}

async function stop() {
  const button = at("stop");
  quiet();
  button.dataset.state = "asked";
  put(at("stop-word"), "stopping …");
  try {
    await connection.stop();
    button.dataset.state = "stopped";
    put(at("stop-word"), "stopped");
    alarm("");
  } catch {
    button.dataset.state = "failed";
    put(at("stop-word"), "NOT STOPPED: cut its power");
    alarm("The robot did not confirm the stop. Cut its power, and press again.");
    return;
  }
  setTimeout(() => {
    if (button.dataset.state !== "stopped") return;
    button.dataset.state = "";
    put(at("stop-word"), "STOP");
  }, STOPPED_FOR);
}

function talk(on) {
  if (on && !microphone.begin()) {
    put(at("voice-note"), "The way for your sound is not open yet.");
    return;
  }
  if (!on) microphone.end();
  at("talk").setAttribute("aria-pressed", String(on));
  put(at("talk"), on ? "Speak …" : "Hold to talk");
}

// No sound is sent any more.
function quiet() {
  at("hands-free").checked = connection.handsFree = false;
  talk(false);
  keepAwake(false);
}

async function keepAwake(on) {
  if (!on) {
    wakeLock?.release();
    wakeLock = null;
  } else if (!document.hidden) {
    wakeLock = await navigator.wakeLock?.request("screen").catch(() => null);
  }
}

// Hands and keys

at("stop").onpointerdown = (event) => event.isPrimary && stop();
at("stop").onclick = (event) => event.detail === 0 && stop(); // by Enter, or a screen reader
at("drive").onclick = () => {
  const over = Boolean(state?.driver);
  if (!over || confirm(`${state.driver_name} drives. Take over? The robot stops.`)) connection.send("drive", { over });
};
at("leave").onclick = () => {
  wantsToDrive = false;
  connection.send("leave");
};
at("rehearse").onchange = ({ target }) => connection.send("rehearse", { on: target.checked });
at("microphone").onclick = async () => {
  put(at("voice-note"), "");
  try {
    await microphone.enable();
  } catch (error) {
    put(at("voice-note"), error.message);
    return;
  }
  at("microphone").hidden = true;
  at("talk").hidden = at("hands-free-label").hidden = false;
  if (driving()) microphone.connect(about.secret);
};
at("talk").onpointerdown = (event) => {
  at("talk").setPointerCapture(event.pointerId);
  talk(true);
};
at("talk").onpointerup = at("talk").onpointercancel = at("talk").onlostpointercapture = () => hold(false);
at("talk").oncontextmenu = (event) => event.preventDefault();
at("hands-free").onchange = ({ target }) => {
  connection.handsFree = target.checked;
  talk(target.checked);
  target.checked = connection.handsFree = microphone.talking && target.checked;
  keepAwake(target.checked);
};

// The button is let go; hands-free goes on.
function hold(on) {
  if (on || !at("hands-free").checked) talk(on);
}

// T, and Enter on the button, are held like it.
function holds(event) {
  const onButton = event.key === "Enter" && document.activeElement === at("talk");
  const choosing = event.target instanceof HTMLSelectElement; // by its first letter
  const letter = event.key.toLowerCase() === "t" && !event.ctrlKey && !event.metaKey && !event.altKey && !choosing;
  return (onButton || letter) && !at("talk").hidden && !at("talk").disabled;
}

addEventListener("keydown", (event) => {
  if (event.key === " ") {
    event.preventDefault();
    if (!event.repeat) stop();
  } else if (holds(event)) {
    event.preventDefault();
    if (!event.repeat) hold(true);
  }
}, { capture: true });
addEventListener("keyup", (event) => {
  if (event.key === " ") event.preventDefault(); // else it would press the button that has the focus
  else if (holds(event)) hold(false);
}, { capture: true });
addEventListener("blur", () => hold(false));
document.addEventListener("visibilitychange", () => {
  if (document.hidden) hold(false);
  else if (at("hands-free").checked) keepAwake(true);
});

// The token of the link is changed for a cookie, and goes nowhere else.
async function enter() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (token) {
    history.replaceState(null, "", "/");
    await fetch("/api/login", {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ token }),
    });
  }
  const answer = await fetch("/api/state");
  if (answer.ok) return true;
  const { error } = await answer.json();
  put(at("status"), "no entry");
  alarm(error);
  return false;
}

at("certificate").hidden = location.protocol !== "https:";
if (await enter().catch(() => true)) connection.begin();
