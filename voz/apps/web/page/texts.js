// What the page shows, in the language of the browser: the robot puts the table into the page. Without one it is English.

const table = JSON.parse(globalThis.document?.getElementById("texts")?.textContent || "{}");
const { texts = {}, notices = [] } = table;
const TRANSLATED = ["what", "why"]; // what is inserted under these names is translated in turn

// A text by its English one, with values inserted for {name}.
export function text(english, values = {}) {
  return (texts[english] ?? english).replace(/\{(\w+)\}/g, (_, name) => values[name]);
}

// What an event or an error of the robot says in English; what is unknown stays as it is.
export function translate(said) {
  for (const [english, pattern] of notices) {
    const found = new RegExp(`^(?:${pattern})$`, "s").exec(said);
    if (!found) continue;
    const values = { ...found.groups };
    for (const name of TRANSLATED) if (name in values) values[name] = translate(values[name]);
    return text(english, values);
  }
  return said;
}

// Join texts by one for two of them, such as "{one} or {other}".
export const list = (joined, all) => all.reduce((one, other) => text(joined, { one, other }));

export const quoted = (said) => text("“{text}”", { text: said });
