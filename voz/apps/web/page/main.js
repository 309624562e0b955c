// Puts the parts of the page together.
import { Connection } from "./connection.js";
import { EventLog } from "./event-log.js";
import { FalseAlarmSlider } from "./false-alarm-slider.js";
import { Microphone } from "./microphone.js";
import { Player } from "./player.js";
import { RecordingMarks } from "./recording-marks.js";
import { Room } from "./room.js";
import * as words from "./words.js";

const FLOOR = -60; // dBFS at which the bar is empty: a quiet room
const LOUD = -3; // dBFS above which a microphone is about to clip
const STOPPED_FOR = 2000; // ms that the button says so

const byId = (id) => document.getElementById(id);
const connection = new Connection(receive, connectionLost);
const post = (address, more) => connection.post(address, more);
const player = new Player(post);
const marks = new RecordingMarks(post, player, (text) => setText(byId("marking-note"), text));
const falseAlarms = new FalseAlarmSlider(byId, post);
const log = new EventLog(byId("log"), (event) => marks.tools(event));
const microphone = new Microphone((text) => setText(byId("voice-note"), text), stopTalking);
let welcomed = null; // what does not change, and which page this is
let state = null; // the current state
let room = null;
let wantsToDrive = false; // it drove before the connection was lost
let wakeLock = null;

// Change a text only if it differs: nothing flickers, and nothing is read out twice.
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function showAlarm(text) {
  setText(byId("alarm"), text);
  byId("alarm").hidden = !text;
}

// A stop that was not confirmed stays in sight until one is.
function clearAlarm() {
  if (byId("stop").dataset.state !== "failed") showAlarm("");
}

const isDriving = () => Boolean(welcomed && state && state.driver === welcomed.page);

// What comes from the robot

function receive(record) {
  if (record.type === "welcome") welcome(record);
  else if (record.type === "state") show(record);
  else if (record.type === "drive") driveAnswered(record);
  else if (record.type === "recording") marks.add(record);
  else if (["utterance", "reply", "warning"].includes(record.type)) log.add(record);
  if (record.type === "reply" && byId("replies").checked && isDriving()) say(record.text);
}

function say(text) {
  const playing = player.play(`/api/reply?text=${encodeURIComponent(text)}`);
  playing.catch((error) => setText(byId("voice-note"), error.message));
}

function welcome(record) {
  welcomed = record;
  clearAlarm();
  room = new Room(byId("room"), record.room);
  marks.fill(record.recordings, record.commands);
  falseAlarms.fill(record.tuning);
  log.fill(record.events);
  byId("voice").hidden = record.microphone !== "browser";
  setText(byId("voice-note"), record.microphone === "browser" ? "" : `The robot listens by its own microphone, ${record.microphone}.`);
  const buttons = record.commands.filter((text) => text !== "stop").map(commandButton);
  byId("commands").replaceChildren(...buttons);
  show(record.now);
  if (wantsToDrive) connection.send("drive");
}

function show(now) {
  const before = state;
  const drove = isDriving();
  state = now;
  room.show(now);
  const [kind, text] = words.status(now);
  byId("status").dataset.kind = kind;
  setText(byId("status"), text);
  setText(byId("linear"), words.velocity(now.linear));
  setText(byId("angular"), words.velocity(now.angular));
  setText(byId("arm"), words.arm(now.selected));
  setText(byId("place"), words.place(now.pose));
  setText(byId("recording"), words.recording(now.recording));
  falseAlarms.show(now.alarms);
  showLevel(now);
  showDriver(now, before);
  if (drove && !isDriving()) stoppedDriving();
}

function showLevel(now) {
  const level = now.peak > 0 ? Math.max(FLOOR, 20 * Math.log10(now.peak)) : FLOOR;
  byId("peak").style.transform = `scaleX(${(1 - level / FLOOR).toFixed(3)})`;
  byId("peak").classList.toggle("loud", level > LOUD);
  const background = Math.min(0, Math.max(FLOOR, now.background));
  byId("background").style.transform = `translateX(${((1 - background / FLOOR) * 100).toFixed(1)}%)`;
  setText(byId("level-words"), `the room is at ${Math.round(now.background)} dB`);
}

function showDriver(now, before) {
  const mine = isDriving();
  setText(byId("driver"), mine ? "you drive" : now.driver ? `${now.driver_name} drives` : "nobody drives");
  byId("drive").hidden = mine;
  setText(byId("drive"), now.driver ? "Take over" : "Drive");
  byId("leave").hidden = !mine;
  byId("rehearse").disabled = !mine;
  // A tick that is still on its way to the robot is not taken away.
  if (!mine || now.rehearsing !== before?.rehearsing) byId("rehearse").checked = now.rehearsing;
  for (const button of byId("commands").children) button.disabled = !mine;
  enableDriverTools(mine);
  byId("microphone").disabled = !mine;
  byId("talk").disabled = byId("hands-free").disabled = !mine || !microphone.ready;
}

// What only the driving page may do besides commands.
function enableDriverTools(mine) {
  for (const part of [player, marks, falseAlarms]) part.enable(mine);
  byId("replies").disabled = !mine;
}

function driveAnswered(record) {
  if (!record.driving) return;
  wantsToDrive = true;
  if (microphone.isEnabled) microphone.connect(welcomed.secret);
}

function stoppedDriving() {
  wantsToDrive = false;
  stopTalking();
  microphone.disconnect();
}

function connectionLost(reason) {
  byId("status").dataset.kind = "lost";
  setText(byId("status"), "no connection");
  showAlarm(reason || "No connection to the robot. It stops if this page drove it.");
  stopTalking();
  enableDriverTools(false);
  microphone.disconnect();
  state = null;
  for (const button of byId("commands").children) button.disabled = true;
}

// What goes to it

function commandButton(text) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = text;
  button.disabled = true;
  button.onclick = () => connection.command(text).then(clearAlarm, (error) => showAlarm(error.message));
  return button;
}

async function stop() {
  const button = byId("stop");
  stopTalking();
  button.dataset.state = "asked";
  setText(byId("stop-word"), "stopping …");
  try {
    await connection.stop();
    button.dataset.state = "stopped";
    setText(byId("stop-word"), "stopped");
    showAlarm("");
  } catch {
    button.dataset.state = "failed";
    setText(byId("stop-word"), "NOT STOPPED: cut its power");
    showAlarm("The robot did not confirm the stop. Cut its power, and press again.");
    return;
  }
  setTimeout(() => {
    if (button.dataset.state !== "stopped") return;
    button.dataset.state = "";
    setText(byId("stop-word"), "STOP");
  }, STOPPED_FOR);
}

function talk(on) {
  if (on && !microphone.begin()) {
    setText(byId("voice-note"), "The connection for your sound is not open yet.");
    return;
  }
  if (!on) microphone.end();
  byId("talk").setAttribute("aria-pressed", String(on));
  setText(byId("talk"), on ? "Speak …" : "Hold to talk");
}

// No sound is sent any more.
function stopTalking() {
  byId("hands-free").checked = connection.handsFree = false;
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

byId("stop").onpointerdown = (event) => event.isPrimary && stop();
byId("stop").onclick = (event) => event.detail === 0 && stop(); // by Enter, or a screen reader
byId("drive").onclick = () => {
  const over = Boolean(state?.driver);
  if (!over || confirm(`${state.driver_name} drives. Take over? The robot stops.`)) connection.send("drive", { over });
};
byId("leave").onclick = () => {
  wantsToDrive = false;
  connection.send("leave");
};
byId("rehearse").onchange = ({ target }) => connection.send("rehearse", { on: target.checked });
byId("microphone").onclick = async () => {
  setText(byId("voice-note"), "");
  try {
    await microphone.enable();
  } catch (error) {
    setText(byId("voice-note"), error.message);
    return;
  }
  byId("microphone").hidden = true;
  byId("talk").hidden = byId("hands-free-label").hidden = false;
  if (isDriving()) microphone.connect(welcomed.secret);
};
byId("talk").onpointerdown = (event) => {
  byId("talk").setPointerCapture(event.pointerId);
  talk(true);
};
byId("talk").onpointerup = byId("talk").onpointercancel = byId("talk").onlostpointercapture = () => hold(false);
byId("talk").oncontextmenu = (event) => event.preventDefault();
byId("hands-free").onchange = ({ target }) => {
  connection.handsFree = target.checked;
  talk(target.checked);
  target.checked = connection.handsFree = microphone.talking && target.checked;
  keepAwake(target.checked);
};

// The button is pressed or released; hands-free goes on.
function hold(on) {
  if (on || !byId("hands-free").checked) talk(on);
}

// T, and Enter on the button, are held like the button.
function isTalkKey(event) {
  const onButton = event.key === "Enter" && document.activeElement === byId("talk");
  const choosing = event.target instanceof HTMLSelectElement; // by its first letter
  const letter = event.key.toLowerCase() === "t" && !event.ctrlKey && !event.metaKey && !event.altKey && !choosing;
  return (onButton || letter) && !byId("talk").hidden && !byId("talk").disabled;
}

addEventListener("keydown", (event) => {
  if (event.key === " ") {
    event.preventDefault();
    if (!event.repeat) stop();
  } else if (isTalkKey(event)) {
    event.preventDefault();
    if (!event.repeat) hold(true);
  }
}, { capture: true });
addEventListener("keyup", (event) => {
  if (event.key === " ") event.preventDefault(); // else it would press the button that has the focus
  else if (isTalkKey(event)) hold(false);
}, { capture: true });
addEventListener("blur", () => hold(false));
document.addEventListener("visibilitychange", () => {
  if (document.hidden) hold(false);
  else if (byId("hands-free").checked) keepAwake(true);
});

// The token of the link is exchanged for a cookie, and sent nowhere else.
async function logIn() {
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
  setText(byId("status"), "no entry");
  showAlarm(error);
  return false;
}

byId("certificate").hidden = location.protocol !== "https:";
if (await logIn().catch(() => true)) connection.start();
