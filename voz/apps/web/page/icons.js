// The icons: strokes on a square of 24.

export const ICONS = {
  forward: "M12 20V5M5.5 11.5 12 5l6.5 6.5",
  back: "M12 4v15M5.5 12.5 12 19l6.5-6.5",
  "turn-left": "M18 20v-6a5 5 0 0 0-5-5H5M10 4 5 9l5 5",
  "turn-right": "M6 20v-6a5 5 0 0 1 5-5h8M14 4l5 5-5 5",
  "rotate-left": "M4.5 4.5v5.5H10M5 10a7.5 7.5 0 1 1-.4 4",
  "rotate-right": "M19.5 4.5v5.5H14M19 10a7.5 7.5 0 1 0 .4 4",
  faster: "M6 12l6-6 6 6M6 18.5l6-6 6 6",
  slower: "M6 5.5l6 6 6-6M6 12l6 6 6-6",
  standing: "M7 7h10v10H7z",
  unknown: "M8.5 9a3.5 3.5 0 1 1 5 3.2c-1 .5-1.5 1-1.5 2.3M12 18.5v.1",
  tick: "M4 13l5.5 5.5L20 6.5",
};

export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}
