// The keys: space stops, always; Enter does what it does on a button, and toggles; T is held to talk.

export function listenToKeys(stop, mainButton) {
  // T anywhere, and Enter on the button, are held like the button.
  function isTalkKey(event) {
    const onButton = event.key === "Enter" && document.activeElement === mainButton.button;
    const letter = event.key.toLowerCase() === "t" && !event.ctrlKey && !event.metaKey && !event.altKey;
    return (onButton || letter) && mainButton.action === "talk";
  }

  addEventListener("keydown", (event) => {
    const { target } = event;
    if (event.key === " ") {
      event.preventDefault();
      if (!event.repeat) stop();
    } else if (isTalkKey(event)) {
      event.preventDefault();
      if (!event.repeat) mainButton.hold(true);
    } else if (event.key === "Enter" && target instanceof HTMLInputElement && target.type === "checkbox") {
      event.preventDefault();
      if (!event.repeat) target.click(); // browsers toggle it by space alone
    }
  }, { capture: true });
  addEventListener("keyup", (event) => {
    if (event.key === " ") event.preventDefault(); // else it would press the button that has the focus
    else if (isTalkKey(event)) mainButton.hold(false);
  }, { capture: true });
}
