// Puts the parts of the page together.
import { Bar } from "./bar.js";
import { Commands } from "./commands.js";
import { Connection } from "./connection.js";
import { byId, setText } from "./dom.js";
import { EventLog } from "./event-log.js";
import { FalseAlarmSlider } from "./false-alarm-slider.js";
import { Heard } from "./heard.js";
import { listenToKeys } from "./keys.js";
import { MainButton } from "./main-button.js";
import { Microphone } from "./microphone.js";
import { Player } from "./player.js";
import { Question } from "./question.js";
import { RecordingMarks } from "./recording-marks.js";
import { Room } from "./room.js";
import { StopButton } from "./stop-button.js";
import { TakeOver } from "./take-over.js";
import { text, translate } from "./texts.js";
import * as words from "./words.js";

const connection = new Connection(receive, connectionLost);
const post = (address, more) => connection.post(address, more);
const player = new Player(post);
const marks = new RecordingMarks(post, player, (note) => setText("marking-note", note));
const falseAlarms = new FalseAlarmSlider(byId, post);
const log = new EventLog(byId("log"), (event) => marks.tools(event));
const bar = new Bar();
const commands = new Commands(give);
const heard = new Heard(give);
const question = new Question(answer);
const microphone = new Microphone((note) => setText("voice-note", note), () => mainButton.stopTalking());
const mainButton = new MainButton(microphone, {
  drive: () => connection.send("drive", { over: false }),
  takeOver: () => takeOver.ask(translate(state.driver_name)),
  allowed: () => wantsToDrive && microphone.connect(welcomed.secret),
  handsFree: goOnHidden,
});
const takeOver = new TakeOver(() => {
  connection.send("drive", { over: true });
  mainButton.allow();
});
const stopButton = new StopButton(connection, stopAsked, (alarm) => bar.alarm("stop", alarm));
let welcomed = null; // what does not change, and which page this is
let state = null; // the current state
let room = null;
let wantsToDrive = false; // it drives, or drove before the connection was lost
let wakeLock = null;

const isDriving = () => Boolean(welcomed && state && state.driver === welcomed.page);

// What comes from the robot

function receive(record) {
  if (record.type === "welcome") welcome(record);
  else if (record.type === "state") show(record);
  else if (record.type === "drive") driveAnswered(record);
  else if (record.type === "recording") marks.add(record);
  else if (record.type === "commands") renewCommands(record);
  else if (record.type === "cmd_vel") stopButton.sent(record);
  else if (["utterance", "reply", "warning"].includes(record.type)) {
    log.add(record);
    heard.add(record);
  }
  if (record.type === "reply" && byId("replies").checked && isDriving()) say(record.text);
}

function say(reply) {
  const playing = player.play(`/api/reply?text=${encodeURIComponent(reply)}`, reply);
  playing.catch((error) => setText("voice-note", error.message));
}

function welcome(record) {
  welcomed = record;
  document.body.dataset.connection = "open";
  bar.found();
  bar.alarm("entry", "");
  bar.alarm("command", "");
  room = new Room(byId("room"), record.room);
  fillCommands(record);
  marks.fill(record.recordings);
  falseAlarms.fill(record.tuning);
  log.fill(record.events);
  heard.fill(record.events);
  mainButton.browserListens = record.microphone === "browser";
  show(record.now);
  if (wantsToDrive) connection.send("drive");
}

function fillCommands(record) {
  commands.fill(record.buttons);
  marks.commands = record.commands;
}

// The list or the table was saved during the run.
function renewCommands(record) {
  welcomed = { ...welcomed, commands: record.commands, buttons: record.buttons, wake: record.wake };
  fillCommands(record);
  commands.enable(isDriving());
}

function show(now) {
  const before = state;
  const drove = isDriving();
  state = now;
  const mine = isDriving();
  const { browserListens } = mainButton;
  const { wake } = welcomed;
  room.show(now);
  bar.show(now, { mine, browserListens, microphoneOn: microphone.ready, wake });
  setText("arm", words.arm(now.selected));
  setText("place", words.place(now.pose));
  setText("recording", words.recording(now.recording));
  falseAlarms.show(now.alarms);
  document.body.dataset.asleep = String(!now.listening);
  heard.show(mine, words.hint(now, mine, wake));
  question.show(now.question, mine);
  showDriver(mine, now, before);
  if (drove && !mine) stoppedDriving(now);
}

function showDriver(mine, now, before) {
  mainButton.show({ connected: true, mine, driver: now.driver });
  byId("leave").hidden = !mine;
  byId("rehearse").disabled = !mine;
  // A tick that is still on its way to the robot is not taken away.
  if (!mine || now.rehearsing !== before?.rehearsing) byId("rehearse").checked = now.rehearsing;
  commands.enable(mine);
  enableDriverTools(mine);
}

// What only the driving page may do besides commands.
function enableDriverTools(mine) {
  for (const part of [player, marks, falseAlarms]) part.enable(mine);
  byId("replies").disabled = !mine;
}

function driveAnswered(record) {
  if (!record.driving) return;
  wantsToDrive = true;
  bar.notice("");
  if (microphone.isEnabled) microphone.connect(welcomed.secret);
}

function stoppedDriving(now) {
  const left = !wantsToDrive;
  wantsToDrive = false;
  mainButton.stopTalking();
  microphone.disconnect();
  if (now.driver) bar.notice(text("{name}, took over. The robot was stopped.", { name: translate(now.driver_name) }));
  else if (!left) bar.notice(text("This page drives no more: it did not answer for some time. The robot was stopped."));
}

function connectionLost(reason) {
  document.body.dataset.connection = "lost";
  bar.lost(reason);
  mainButton.stopTalking();
  mainButton.show({ connected: false });
  takeOver.close();
  enableDriverTools(false);
  commands.enable(false);
  heard.show(false, "");
  question.show(null, false);
  microphone.disconnect();
  for (const id of ["rehearse", "replies"]) byId(id).disabled = true;
  state = null;
}

// What goes to it

// A sentence that is tapped while the robot is asleep wakes it first, unless a stop comes between.
function give(sentence) {
  const button = welcomed.buttons.find((one) => one.text === sentence);
  const stops = connection.stops;
  const wake = !state?.listening && button?.group !== "Listening" && welcomed.wake;
  return showFailure(async () => {
    if (wake) await connection.command(wake);
    if (connection.stops === stops) await connection.command(sentence);
  });
}

function answer(sentence) {
  return showFailure(() => connection.command(sentence));
}

async function showFailure(send) {
  try {
    await send();
    bar.alarm("command", "");
  } catch (error) {
    bar.alarm("command", error.message);
  }
}

function stopAsked() {
  mainButton.stopTalking();
  bar.alarm("command", "");
}

// A page that is hands-free drives on while nobody sees it; its screen stays on.
async function goOnHidden(on) {
  connection.handsFree = on;
  if (!on) {
    wakeLock?.release();
    wakeLock = null;
  } else if (!document.hidden) {
    wakeLock = await navigator.wakeLock?.request("screen").catch(() => null);
  }
}

byId("leave").onclick = () => {
  wantsToDrive = false;
  connection.send("leave");
};
byId("rehearse").onchange = ({ target }) => connection.send("rehearse", { on: target.checked });
listenToKeys(() => stopButton.press(), mainButton);
addEventListener("blur", () => mainButton.hold(false));
document.addEventListener("visibilitychange", () => {
  if (document.hidden) mainButton.hold(false);
  else if (mainButton.isHandsFree) goOnHidden(true);
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
  setText("ear-word", text("no entry"));
  bar.alarm("entry", translate(error));
  return false;
}

byId("certificate").hidden = location.protocol !== "https:";
if (await logIn().catch(() => true)) connection.start();
