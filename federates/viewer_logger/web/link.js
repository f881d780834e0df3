// The WebSocket to the viewer: reconnects by itself and says when nothing is heard.

import { person } from "./local.js";

const SILENT_MS = 3500; // the server says something at least once a second
const RETRY_MS = [300, 600, 1200, 2500, 5000];

/** The key of the address (…#key=…), where the page is reached from another host: kept for this tab, off the address bar. */
function token() {
  const parts = location.hash.slice(1).split("&"), at = parts.findIndex((p) => p.startsWith("key="));
  const shown = at < 0 ? null : parts.splice(at, 1)[0].slice(4);
  if (shown) {
    sessionStorage.setItem("token", shown);
    history.replaceState(null, "", location.pathname + (parts.length ? `#${parts.join("&")}` : ""));
  }
  return shown ?? sessionStorage.getItem("token");
}

export class Link {
  #socket = null;
  #retries = 0;
  #heard = 0;
  #ids = 0;
  #waiting = new Map();
  #hello = () => [];
  #token = null;

  /** `on` has `text(message)`, `scan(buffer)`, `state(word)`; word is connecting, open, silent or lost. */
  constructor(on, hello) {
    this.on = on;
    this.#hello = hello;
    this.#token = token();
    this.state = "connecting";
    setInterval(() => this.#watch(), 500);
    this.#open();
  }

  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** Sends a command; resolves to { accepted, text }. */
  command(message) {
    const id = ++this.#ids;
    return new Promise((resolve) => {
      if (!this.send({ type: "command", id, ...message })) {
        resolve({ accepted: false, text: "not sent: no connection to the viewer" });
        return;
      }
      this.#waiting.set(id, resolve);
    });
  }

  #open() {
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket?person=${encodeURIComponent(person())}${location.pathname === "/eye" ? "&eye=true" : ""}`);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    socket.onopen = () => {
      this.#retries = 0;
      this.#heard = performance.now();
      this.#become("open");
      if (this.#token) this.send({ type: "token", token: this.#token });
      for (const message of this.#hello()) this.send(message);
    };
    socket.onmessage = (event) => {
      this.#heard = performance.now();
      if (this.state !== "open") this.#become("open");
      if (event.data instanceof ArrayBuffer) {
        this.on.scan(event.data);
        return;
      }
      let message;
      try {
        message = JSON.parse(event.data);
      } catch {
        message = { type: "unreadable" };
      }
      if (message?.type === "reply") {
        this.#waiting.get(message.id)?.(message);
        this.#waiting.delete(message.id);
      }
      this.on.text(message);
    };
    socket.onclose = () => {
      for (const resolve of this.#waiting.values()) {
        resolve({ accepted: false, text: "the connection broke before the answer came" });
      }
      this.#waiting.clear();
      this.#become("lost");
      const wait = RETRY_MS[Math.min(this.#retries++, RETRY_MS.length - 1)];
      setTimeout(() => this.#open(), wait);
    };
  }

  #watch() {
    if (this.state === "open" && performance.now() - this.#heard > SILENT_MS) this.#become("silent");
  }

  #become(state) {
    this.state = state;
    this.on.state(state);
  }
}
