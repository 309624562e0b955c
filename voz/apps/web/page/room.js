// The robot in its room, from above. What changes is moved, never redrawn: nothing flickers.
import { text } from "./texts.js";

const MAX_PLACES = 1500;
const MIN_STEP = 0.01; // between two places of the path, m
const VIEW = 3; // what is shown at least where no room is known, m
const EDGE = 0.06; // around the room, m
const MIN_ROBOT = 72; // px across; where the whole room would make it smaller, a part of it is shown

function add(parent, name, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

// A label stands upright though y goes up.
function label(parent, word, x, y) {
  add(parent, "text", { class: "label", x, y: -y, transform: "scale(1 -1)" }).textContent = word;
}

const points = (places) => places.map((place) => place.join(",")).join(" ");

export class Room {
  constructor(svg, room) {
    svg.replaceChildren();
    svg.classList.remove("moving");
    this.svg = svg;
    this.room = room;
    this.radius = room ? room.radius : 0.17;
    this.places = [];
    this.heading = 0;
    this.world = add(svg, "g", { class: "world" });
    if (room) this.drawRoom(room);
    else this.grid = add(this.world, "path", { class: "grid" });
    this.track = add(this.world, "polyline", { class: "track", "stroke-width": 2 * this.radius });
    this.path = add(this.world, "polyline", { class: "way" });
    this.drawRobot();
    this.arm = add(this.world, "polyline", { class: "arm" }); // above the base
    new ResizeObserver(() => this.measure()).observe(svg);
    this.measure();
  }

  drawRoom(room) {
    const [width, height] = room.room;
    add(this.world, "rect", { class: "floor", width, height, rx: 0.03 });
    const [x, y, along, across] = room.table;
    add(this.world, "rect", { class: "table", x, y, width: along, height: across, rx: 0.03 });
    add(this.world, "rect", { class: "walls", width, height, rx: 0.03 });
    for (const name of ["beer", "cocacola"]) {
      const [px, py] = room[name];
      add(this.world, "circle", { class: "object", cx: px, cy: py, r: 0.045 });
      label(this.world, text(name), px, py + 0.08);
    }
  }

  // Wheels, a body, a nose where it drives to, and eyes.
  drawRobot() {
    this.robot = add(this.world, "g", { class: "robot", id: "robot" });
    const own = add(this.robot, "g", { transform: `scale(${this.radius})` });
    for (const y of [0.72, -1.02]) add(own, "rect", { class: "wheel", x: -0.4, y, width: 0.8, height: 0.3, rx: 0.12 });
    add(own, "path", { class: "body", d: "M1.32 0 L.9 .42 L.9 -.42 Z" });
    add(own, "circle", { class: "body", r: 0.96 });
    for (const y of [0.34, -0.34]) add(own, "circle", { class: "eye", cx: 0.46, cy: y, r: 0.19 });
  }

  show(state) {
    const [x, y, heading] = state.pose;
    this.place = [x, y];
    this.addPlace(x, y);
    // The short way round: a robot that turns past 180 degrees must not spin back.
    const turn = heading - this.heading;
    this.heading += turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI));
    this.robot.style.transform = `translate(${x}px, ${y}px) rotate(${this.heading}rad)`;
    this.robot.classList.toggle("collided", Boolean(state.collided));
    this.arm.setAttribute("points", points(state.arm || []));
    this.look();
  }

  addPlace(x, y) {
    const last = this.places.at(-1);
    if (last && Math.hypot(x - last[0], y - last[1]) < MIN_STEP) return;
    this.setPath([...this.places, [x, y]]);
  }

  // Show another path, which leads to where the robot is now.
  setPath(places) {
    this.places = places.slice(-MAX_PLACES);
    for (const line of [this.path, this.track]) line.setAttribute("points", points(this.places));
  }

  measure() {
    const { width, height } = this.svg.getBoundingClientRect();
    [this.width, this.height] = [width, height];
    this.svg.setAttribute("viewBox", `0 0 ${Math.max(1, width)} ${Math.max(1, height)}`);
    this.look();
  }

  // Move the world so that the robot is in sight, and large.
  look() {
    if (!this.place || !this.width || !this.height) return;
    const [along, across] = this.room ? this.room.room.map((size) => size + 2 * EDGE) : [VIEW, VIEW];
    const whole = Math.min(this.width / along, this.height / across);
    const scale = Math.max(whole, MIN_ROBOT / (2 * this.radius)); // px per m
    const [x, y] = [0, 1].map((axis) => this.center(axis, [this.width, this.height][axis] / scale));
    const [left, top] = [this.width / 2 - x * scale, this.height / 2 + y * scale];
    this.world.style.transform = `translate(${left}px, ${top}px) scale(${scale}, ${-scale})`;
    if (this.grid) this.drawGrid(x, y, this.width / scale / 2 + 1, this.height / scale / 2 + 1);
    if (this.svg.classList.contains("moving")) return;
    this.svg.getBoundingClientRect(); // the first place is no motion
    this.svg.classList.add("moving");
  }

  // The middle of what is seen along an axis, of which so many meters are in sight.
  center(axis, seen) {
    const place = this.place[axis];
    if (!this.room) return place;
    const size = this.room.room[axis];
    if (seen >= size + 2 * EDGE) return size / 2;
    return Math.min(size + EDGE - seen / 2, Math.max(seen / 2 - EDGE, place));
  }

  drawGrid(x, y, along, across) {
    let lines = "";
    for (let at = Math.ceil((x - along) * 2) / 2; at <= x + along; at += 0.5) lines += `M${at} ${y - across} V${y + across} `;
    for (let at = Math.ceil((y - across) * 2) / 2; at <= y + across; at += 0.5) lines += `M${x - along} ${at} H${x + along} `;
    this.grid.setAttribute("d", lines);
  }
}
