// What is wrong with how a page is laid out: texts that are cut, and controls that overlap.
() => {
  const faults = [];
  const shown = (element) => element.checkVisibility({ visibilityProperty: true }) && !element.closest(".unseen, noscript");
  const name = (element) => `${element.id || element.className || element.tagName} "${element.textContent.trim().slice(0, 30)}"`;

  // The part of an element's box that no ancestor hides.
  function seen(element) {
    let { left, top, right, bottom } = element.getBoundingClientRect();
    for (let above = element; (above = above.parentElement); ) {
      if (getComputedStyle(above).overflowY === "visible") continue;
      const box = above.getBoundingClientRect();
      [left, top] = [Math.max(left, box.left), Math.max(top, box.top)];
      [right, bottom] = [Math.min(right, box.right), Math.min(bottom, box.bottom)];
    }
    return { left, top, right, bottom };
  }

  // Each line of text is within the control or box that it stands in.
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const text = texts.currentNode;
    const own = text.parentElement;
    if (!text.data.trim() || !shown(own) || own.closest("svg, script")) continue;
    const around = own.closest("button, .fact, #driver, .where, .dock, header, section");
    if (!around) continue;
    const box = around.getBoundingClientRect();
    const range = document.createRange();
    range.selectNodeContents(text);
    for (const { index, 0: word } of around.matches("button, .fact") ? text.data.matchAll(/\S+/g) : []) {
      const inside = document.createRange();
      inside.setStart(text, index);
      inside.setEnd(text, index + word.length);
      if (new Set([...inside.getClientRects()].map(({ top }) => top)).size > 1) faults.push(`broken word: ${name(own)}`);
    }
    for (const line of range.getClientRects()) {
      if (line.left < box.left - 1 || line.right > box.right + 1) faults.push(`cut at a side: ${name(own)} in ${name(around)}`);
      const scrolls = around.matches("header, .dock, section");
      if (!scrolls && (line.top < box.top - 1 || line.bottom > box.bottom + 1)) faults.push(`cut above or below: ${name(own)} in ${name(around)}`);
    }
  }

  const controls = [...document.querySelectorAll("button, a, .switch, .fact, .where, .slider, #heard, #reply, #driver, h1, #stop-note")].filter(shown);
  const boxes = controls.map(seen);
  for (const [at, one] of controls.entries()) {
    for (const [after, other] of controls.entries()) {
      if (after <= at || one.contains(other) || other.contains(one)) continue;
      const [a, b] = [boxes[at], boxes[after]];
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 1 && high > 1) faults.push(`overlap: ${name(one)} and ${name(other)}`);
    }
  }
  return [...new Set(faults)];
}
