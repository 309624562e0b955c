// The one thread that talks to the robot, for all that does so on this page.

export const link = new Worker("/page/link-thread.js", { type: "module" });

// A page that has gone must not be answered for; one that comes back from the browser's memory begins anew.
addEventListener("pagehide", () => link.terminate());
addEventListener("pageshow", (event) => event.persisted && location.reload());
