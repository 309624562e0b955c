// The robot in its room, from above. What changes is moved, never redrawn: nothing flickers.

const MAX_PLACES = 1500;
const MIN_STEP = 0.01; // between two places of the path, m
const VIEW_RADIUS = 1.5; // what is shown where no room is known, m

function add(parent, name, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

// A label stands upright though y goes up.
function label(parent, text, x, y) {
  add(parent, "text", { class: "label", x, y: -y, transform: "scale(1 -1)" }).textContent = text;
}

export class Room {
  constructor(svg, room) {
    svg.replaceChildren();
    this.svg = svg;
    this.room = room;
    this.places = [];
    this.heading = 0;
    const world = add(svg, "g", { transform: "scale(1 -1)" });
    if (room) this.drawRoom(world, room);
    else this.grid = add(world, "path", { class: "grid" });
    this.path = add(world, "polyline", { class: "way" });
    this.arm = add(world, "polyline", { class: "arm" });
    const radius = room ? room.radius : 0.17;
    this.robot = add(world, "g", { class: "robot", id: "robot" });
    add(this.robot, "circle", { class: "body", r: radius });
    add(this.robot, "path", {
      class: "nose",
      d: `M${radius * 0.8} 0 L${radius * 0.1} ${radius * 0.45} L${radius * 0.1} ${-radius * 0.45} Z`,
    });
    world.append(this.arm); // above the base
  }

  drawRoom(world, room) {
    const [width, depth] = room.room;
    const edge = 0.06;
    this.svg.setAttribute("viewBox", `${-edge} ${-depth - edge} ${width + 2 * edge} ${depth + 2 * edge}`);
    add(world, "rect", { class: "floor", width, height: depth });
    const [x, y, along, across] = room.table;
    add(world, "rect", { class: "table", x, y, width: along, height: across, rx: 0.02 });
    add(world, "rect", { class: "walls", width, height: depth });
    for (const name of ["beer", "cocacola"]) {
      const [px, py] = room[name];
      add(world, "circle", { class: name, cx: px, cy: py, r: 0.045 });
      label(world, name, px, py + 0.07);
    }
  }

  show(state) {
    const [x, y, heading] = state.pose;
    this.addPlace(x, y);
    // The short way round: a robot that turns past 180 degrees must not spin back.
    const turn = heading - this.heading;
    this.heading += turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI));
    this.robot.style.transform = `translate(${x}px, ${y}px) rotate(${this.heading}rad)`;
    this.robot.classList.toggle("collided", Boolean(state.collided));
    this.arm.setAttribute("points", (state.arm || []).map((point) => point.join(",")).join(" "));
    this.svg.dataset.x = x;
    this.svg.dataset.y = y;
  }

  addPlace(x, y) {
    const last = this.places.at(-1);
    if (last && Math.hypot(x - last[0], y - last[1]) < MIN_STEP) return;
    this.places.push([x, y]);
    if (this.places.length > MAX_PLACES) this.places.shift();
    this.path.setAttribute("points", this.places.map((place) => place.join(",")).join(" "));
    if (!this.room) this.centerOn(x, y);
  }

  // Show another path, which leads to where the robot is now.
  setPath(places) {
    this.places = places.slice(-MAX_PLACES);
    this.path.setAttribute("points", this.places.map((place) => place.join(",")).join(" "));
  }

  centerOn(x, y) {
    this.svg.setAttribute("viewBox", `${x - VIEW_RADIUS} ${-y - VIEW_RADIUS} ${2 * VIEW_RADIUS} ${2 * VIEW_RADIUS}`);
    let lines = "";
    for (let line = -2; line <= 2; line += 0.5) {
      const [atX, atY] = [Math.round(x * 2) / 2 + line, Math.round(y * 2) / 2 + line];
      lines += `M${atX} ${y - 2} V${y + 2} M${x - 2} ${atY} H${x + 2} `;
    }
    this.grid.setAttribute("d", lines);
  }
}
