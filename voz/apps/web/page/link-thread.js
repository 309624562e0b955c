// The thread that talks to the robot: sound and answers go on while the page is busy.
import { EventSocket } from "./event-socket.js";
import { SoundSocket } from "./sound-socket.js";

const tell = (message) => postMessage(message);
const events = new EventSocket(tell);
const sound = new SoundSocket(tell, () => events.isPageThere());

const actions = {
  open: () => events.open(),
  seen: ({ at, attended }) => events.pageShowed(at, attended),
  attended: ({ attended }) => events.setAttended(attended),
  send: ({ message }) => events.send(message),
  microphone: ({ port, rate }) => sound.listenTo(port, rate),
  connect: ({ secret, number }) => sound.connect(secret, number),
  disconnect: () => sound.disconnect(),
  begin: ({ held }) => sound.begin(held),
  end: () => sound.end(),
};

onmessage = ({ data }) => actions[data.type](data);
