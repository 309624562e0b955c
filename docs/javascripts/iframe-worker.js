// Lets the search work in pages that are opened from a disk: browsers start no worker there, so its
// script runs in a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.frame = frame.contentWindow;
      this.loaded = new Promise((resolve) => {
        const inside = frame.contentDocument;
        inside.open();
        this.frame.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
        this.frame.importScripts = (...urls) => Promise.all(urls.map((one) => load(inside, one)));
        inside.write("<!doctype html><title>search</title><body>");
        inside.close();
        load(inside, url).then(resolve);
      });
    }

    postMessage(data) {
      const take = () => this.frame.dispatchEvent(new this.frame.MessageEvent("message", { data }));
      this.loaded.then(take);
    }
  };

  function load(page, url) {
    return new Promise((resolve, reject) => {
      const script = page.createElement("script");
      Object.assign(script, { src: url, async: false, onload: resolve, onerror: reject });
      page.body.append(script);
    });
  }
}
