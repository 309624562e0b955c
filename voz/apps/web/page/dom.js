// Small helpers for elements of a page.

export const byId = (id) => document.getElementById(id);

// Change a text only if it differs: nothing flickers, and nothing is read out twice.
export function setText(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}

export function element(name, className, ...content) {
  const made = document.createElement(name);
  if (className) made.className = className;
  made.append(...content);
  return made;
}
