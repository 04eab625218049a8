// The client against a real server: frames, poses and their way, edits, refusals, a server that goes.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { WebSocket } from "ws";
import {
  jointPositions,
  LiveClient,
  LiveError,
  type FrameMessage,
  type Options,
  type PersonPose,
  type SocketClass,
} from "@halfphysics/client";
import { serve, type Served } from "./server.js";

const SOCKET = WebSocket as unknown as SocketClass;
let served: Served;

before(async () => {
  served = await serve("kick_ball", "--port", "0", "--fps", "60");
});
after(() => served.stop());

const connect = (options: Options = {}): Promise<LiveClient> =>
  LiveClient.connect(served.url, { WebSocket: SOCKET, ...options });

function frames(client: LiveClient, count: number): Promise<FrameMessage[]> {
  return new Promise((resolve) => {
    const found: FrameMessage[] = [];
    const off = client.on("frame", (frame) => {
      found.push(frame);
      if (found.length < count) return;
      off();
      resolve(found);
    });
  });
}

async function with_<T>(options: Options, task: (client: LiveClient) => Promise<T>): Promise<T> {
  const client = await connect(options);
  try {
    return await task(client);
  } finally {
    client.close();
  }
}

for (const binary of [true, false]) {
  test(`hello and frames, ${binary ? "MessagePack" : "JSON"}`, () =>
    with_({ binary }, async (client) => {
      const hello = client.hello!;
      assert.equal(hello.version, 1);
      assert.equal(hello.fps, 60);
      assert.equal(hello.joints.length, 55);
      assert.equal(hello.parents[0], -1);
      assert.equal(hello.people[0]!.joints.length, 55);
      assert.ok(hello.objects.some((item) => item.name === "ball" && item.mass === 0.43));
      const [first, second] = await frames(client, 2);
      assert.ok(second!.frame > first!.frame);
      assert.ok(Math.abs(second!.time - first!.time - (second!.frame - first!.frame) / 60) < 1e-9);
      const person = first!.people[hello.people[0]!.name]!;
      assert.equal(person.rotations!.length, 55);
      assert.equal(first!.objects!["ball"]!.position.length, 3);
    }));
}

test("a pose comes back corrected, with our time stamp", () =>
  with_({}, async (client) => {
    const name = client.hello!.people[0]!.name;
    const [now] = await frames(client, 1);
    const { translation, rotations } = now!.people[name]!;
    const pose: PersonPose = { translation: translation!, rotations: rotations!.map((one) => [...one]) };
    pose.rotations[16] = [0, 0, -1.2]; // the left shoulder
    const heard = new Promise<FrameMessage>((resolve) => {
      client.on("frame", (frame) => {
        if (frame.people[name]!.stamp?.sent === 123.25) resolve(frame);
      });
    });
    const moving = setInterval(() => client.sendPose({ [name]: pose }, 123.25), 15);
    const frame = await heard;
    const stamp = frame.people[name]!.stamp!;
    assert.ok(stamp.stepped >= stamp.received);
    await frames(client, 60);
    const [last] = await frames(client, 1);
    clearInterval(moving);
    const turn = last!.people[name]!.rotations![16]!;
    assert.ok(Math.hypot(turn[0], turn[1], turn[2] + 1.2) < 0.05, `${turn}`);
    assert.equal(last!.people[name]!.tracking, "live");
  }));

test("the scene is edited, and everybody hears of it", () =>
  with_({}, (other) =>
    with_({}, async (client) => {
      const told = new Promise<string[]>((resolve) => {
        other.on("scene", (scene) => resolve(scene.objects.map((item) => item.name)));
      });
      await client.edit({ action: "add", name: "crate", shape: "box:0.2:0.2:0.2", mass: 2, position: [0, 2, 1] });
      assert.ok((await told).includes("crate"));
      await client.edit({ action: "mass", name: "crate", value: 3 });
      await client.edit({ action: "remove", name: "crate" });
    })));

test("a drag moves the ball to the pointer", () =>
  with_({}, async (client) => {
    const [now] = await frames(client, 1);
    const grip = now!.objects!["ball"]!.position;
    await client.edit({ action: "drag", name: "ball", pointer: grip, grip });
    await client.edit({ action: "drag", name: "ball", pointer: [grip[0], grip[1] + 1, 1] });
    const moved = await frames(client, 60);
    const [x, y, z] = moved.at(-1)!.objects!["ball"]!.position;
    assert.ok(Math.hypot(x - grip[0], y - grip[1] - 1, z - 1) < 0.05, `${[x, y, z]}`);
    await client.edit({ action: "drag", name: "ball", pointer: null });
  }));

test("what the server refuses is an error that says why", () =>
  with_({}, async (client) => {
    await assert.rejects(client.edit({ action: "mass", name: "moon", value: 1 }), (error: LiveError) => {
      assert.equal(error.code, "refused");
      assert.match(error.message, /moon/);
      return true;
    });
    const told = new Promise<LiveError>((resolve) => client.on("error", resolve));
    client.sendPose({ nobody: { translation: [0, 0, 0], rotations: Array.from({ length: 55 }, () => [0, 0, 0]) } });
    assert.match((await told).message, /nobody/);
  }));

test("a subscription thins frames, and a ping tells the server's clock", () =>
  with_({ subscribe: { parts: ["objects"], rate: 10 } }, async (client) => {
    await client.ping();
    assert.ok(client.stats.latency! < 0.5);
    const found = await frames(client, 4);
    const spacing = (found.at(-1)!.time - found[1]!.time) / 2;
    assert.ok(Math.abs(spacing - 0.1) < 0.02, `${spacing}`);
    assert.equal(found[0]!.contacts, undefined);
    assert.ok(Math.abs(client.serverTime! - found.at(-1)!.clock) < 0.5);
    await client.subscribe({ parts: ["objects", "contacts"] });
    const [all] = await frames(client, 1);
    assert.ok(Array.isArray(all!.contacts));
  }));

test("joints stand on the floor", () =>
  with_({}, async (client) => {
    const [frame] = await frames(client, 1);
    const person = client.hello!.people[0]!;
    const { translation, rotations } = frame!.people[person.name]!;
    const places = jointPositions(client.hello!, person, translation!, rotations!);
    const foot = client.hello!.joints.indexOf("left_foot");
    const head = client.hello!.joints.indexOf("head");
    assert.ok(places[foot]![2] > 0 && places[foot]![2] < 0.15, `${places[foot]}`);
    assert.ok(places[head]![2] > 1.2);
  }));

test("nobody at the address", async () => {
  await assert.rejects(
    LiveClient.connect("ws://127.0.0.1:9", { WebSocket: SOCKET, patience: 5 }),
    (error: LiveError) => error.code === "closed",
  );
});

test("a client comes back when the server does", async () => {
  const first = await serve("kick_ball", "--port", "0");
  const port = new URL(first.url).port;
  const client = await LiveClient.connect(first.url, { WebSocket: SOCKET });
  const lost = new Promise<number | null>((resolve) => client.on("close", ({ again }) => resolve(again)));
  await first.stop("SIGKILL");
  assert.ok((await lost)! < 1);
  assert.equal(client.sendPose({}), false);
  await assert.rejects(client.ping(), (error: LiveError) => error.code === "closed");
  const second = await serve("kick_ball", "--port", port);
  if (!client.connected) await new Promise<void>((resolve) => void client.on("hello", () => resolve()));
  await frames(client, 2);
  assert.equal(client.stats.connections, 2);
  client.close();
  await second.stop();
});
