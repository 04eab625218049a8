// The test page of the client: shows a live session, drags its objects, says how fast it is.

import { LiveClient, type FrameMessage, type Hello, type Point, type SceneItem } from "../src/index.js";
import { add, Camera } from "./camera.js";
import { Drawing } from "./drawing.js";

const DEFAULT = "ws://127.0.0.1:8765";
const find = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

const camera = new Camera();
const canvas = find<HTMLCanvasElement>("scene");
const drawing = new Drawing(canvas, camera);
let client: LiveClient | null = null;
let frame: FrameMessage | null = null;
let latency: number | null = null;
let fresh = false;
const heard: number[] = [];

/** The session's address: that of this page where a server sent it, else the usual one. */
function address(): string {
  const given = new URLSearchParams(location.search).get("server");
  if (given) return given;
  if (!location.protocol.startsWith("http")) return DEFAULT;
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return `${scheme}://${location.host}/${location.search}`;
}

const say = (text: string): void => void (find("said").textContent = text);

async function connect(): Promise<void> {
  client?.close();
  frame = null;
  const url = find<HTMLInputElement>("address").value;
  say(`Connecting to ${url} ...`);
  try {
    const parts = ["poses", "targets", "objects", "contacts"] as const;
    client = await LiveClient.connect(url, { name: "test page", subscribe: { parts: [...parts] } });
  } catch (error) {
    say((error as Error).message);
    return;
  }
  say("");
  aim();
  client.on("frame", (message) => {
    frame = message;
    fresh = true;
    const now = performance.now() / 1000;
    heard.push(now);
    while (heard[0]! < now - 1) heard.shift();
    const server = client?.serverTime;
    if (server) latency = server - message.clock;
  });
  client.on("scene", () => (fresh = true));
  client.on("error", (error) => say(error.message));
  client.on("hello", () => say(""));
  client.on("close", ({ reason, again }) =>
    say(again === null ? reason : `${reason}; again in ${again} s`));
}

/** The camera looks at the people, or at the objects of a scene without people. */
function aim(): void {
  const hello = client?.hello;
  const some = hello?.objects[0];
  if (hello && !hello.people.length && some) camera.target = [some.position[0], some.position[1], 0.7];
}

function panel(): void {
  const { hello, stats } = client ?? {};
  const text = (id: string, value: string): void => void (find(id).textContent = value);
  text("rate", hello ? `${heard.length} of ${hello.fps} frames/s` : "");
  text("late", latency === null ? "" : `${(1000 * Math.max(latency, 0)).toFixed(1)} ms`);
  text("lost", stats ? `${stats.dropped}` : "");
  text("touch", `${frame?.contacts?.length ?? 0}`);
  const people = Object.entries(frame?.people ?? {});
  text("people", people.map(([name, one]) => `${name}: ${one.tracking}`).join(", "));
}

// -- the pointer: objects are dragged, else the camera turns ---------------------------------------

let held: { item: SceneItem; depth: number } | null = null;
let from: { x: number; y: number } | null = null;

function under(x: number, y: number): { item: SceneItem; depth: number; point: Point } | null {
  let best: { item: SceneItem; depth: number; point: Point } | null = null;
  for (const item of client?.hello?.objects ?? []) {
    if (!item.mass) continue;
    const place = frame?.objects?.[item.name]?.position ?? item.position;
    const pixel = camera.project(place);
    if (!pixel) continue;
    const reach = Math.max(camera.size(0.15, pixel.depth), 18);
    if (Math.hypot(pixel.x - x, pixel.y - y) > reach || (best && best.depth < pixel.depth)) continue;
    best = { item, depth: pixel.depth, point: place };
  }
  return best;
}

const drag = (pointer: Point | null, grip?: Point): void => {
  const action = { action: "drag", name: held!.item.name, pointer, grip: grip ?? null } as const;
  client?.edit(action).catch((error: Error) => say(error.message));
};

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  from = { x: event.offsetX, y: event.offsetY };
  const found = under(event.offsetX, event.offsetY);
  if (!found) return;
  held = found;
  const pointer = camera.unproject(event.offsetX, event.offsetY, found.depth);
  drag(pointer, pointer);
});
canvas.addEventListener("pointermove", (event) => {
  if (!from) return;
  if (held) drag(camera.unproject(event.offsetX, event.offsetY, held.depth));
  else camera.turn(event.offsetX - from.x, event.offsetY - from.y);
  from = { x: event.offsetX, y: event.offsetY };
  fresh = true;
});
for (const end of ["pointerup", "pointercancel"] as const) {
  canvas.addEventListener(end, () => {
    if (held) drag(null);
    [held, from] = [null, null];
  });
}
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  camera.distance = Math.min(Math.max(camera.distance * Math.exp(event.deltaY * 0.001), 0.8), 30);
  fresh = true;
}, { passive: false });
addEventListener("resize", () => (fresh = true));

/** The camera goes along with the first person who is seen. */
function follow(hello: Hello): void {
  const person = hello.people.find(({ name }) => frame?.people[name]?.translation);
  if (!person || !camera.following) return;
  const place = add(frame!.people[person.name]!.translation!, person.joints[0]!);
  camera.target = add(camera.target, add([place[0], place[1], 0.9], camera.target, -1), 0.1);
}

function loop(): void {
  if (fresh && client?.hello) {
    fresh = false;
    follow(client.hello);
    drawing.show(client.hello, frame);
    panel();
  }
  requestAnimationFrame(loop);
}

find<HTMLInputElement>("address").value = address();
find<HTMLFormElement>("server").addEventListener("submit", (event) => {
  event.preventDefault();
  void connect();
});
setInterval(() => client?.connected && client.ping().catch(() => undefined), 500);
Object.assign(window, { live: { get client() { return client; }, get frame() { return frame; }, camera } });
requestAnimationFrame(loop);
void connect();
