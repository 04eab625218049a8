// The way into viser's page: its scene, its camera and its messages. viser puts `__viserMutable` on
// the window when its canvas is there; nothing works before, and all tasks wait for it.

let viser = null;
const waiting = [];
const watchers = []; // called with every message before viser sees it; true: viser never sees it

function whenReady(task) {
  if (viser) task();
  else waiting.push(task);
}

function attach(found) {
  if (!found || found === viser) return;
  viser = found;
  const queue = found.messageQueue;
  const kept = queue.splice(0).filter((message) => !watched(message));
  queue.push(...kept);
  queue.push = (...messages) =>
    Array.prototype.push.apply(queue, messages.filter((message) => !watched(message)));
  for (const task of waiting.splice(0)) task();
}

function watched(message) {
  return watchers.map((watch) => watch(message)).includes(true);
}

let mutable;
Object.defineProperty(window, "__viserMutable", {
  configurable: true,
  get: () => mutable,
  set: (value) => {
    mutable = value;
    attach(value);
  },
});

const node = (name) => viser.nodeRefFromName[name];
const redraw = () => viser && viser.requestRender();

// viser's world is z-up, that of three.js y-up; `root` turns one into the other.
const toThree = (p) => node("").localToWorld(viser.camera.position.clone().set(...p));
const fromThree = (v) => node("").worldToLocal(v.clone()).toArray();

const dark = matchMedia("(prefers-color-scheme: dark)").matches;
document.documentElement.classList.toggle("hp-dark", dark);
watchers.push((message) => {
  if (message.type === "ThemeConfigurationMessage") message.dark_mode = dark;
});

// -- small helpers for the page's own elements ------------------------------------------------

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const whenLoaded = (task) =>
  document.readyState === "loading" ? addEventListener("DOMContentLoaded", task) : task();

let sentence = null;
/** One sentence over the scene, for a few seconds. */
function say(text, seconds = 6) {
  if (!sentence) {
    sentence = make("div", { id: "hp-said", role: "status" });
    document.body.append(sentence);
  }
  sentence.textContent = text;
  sentence.hidden = !text;
  clearTimeout(say.timer);
  if (text) say.timer = setTimeout(() => say(""), 1000 * seconds);
}

/** The bytes of base64 text, inflated. */
async function inflated(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return inflate(packed, "deflate");
}

async function inflate(bytes, how) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(how));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
