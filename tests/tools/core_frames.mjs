// Steps a world by WebAssembly, for test_wasm_sources.py: node core_frames.mjs CORE_FOLDER WORLD POSES OUT
//
// POSES: doubles, frames per second, then the poses of one person, translation and rotations. OUT gets the bodies after each
// frame; what is printed is one line of JSON.
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, worldFile, posesFile, out] = process.argv.slice(2);
const { HalfPhysics, HalfPhysicsError } = await import(pathToFileURL(`${folder}/halfphysics.js`));
const core = await HalfPhysics.load(pathToFileURL(`${folder}/halfphysics.wasm`));
const world = core.world(readFileSync(worldFile));
const file = readFileSync(posesFile);
const [fps, ...numbers] = new Float64Array(file.buffer, file.byteOffset, file.length / 8);
const poses = [];
for (let at = 0; at < numbers.length; at += 168)
  poses.push({ translation: numbers.slice(at, at + 3), rotations: numbers.slice(at + 3, at + 168) });

function run(from, each) {
  const begin = process.cpuUsage();
  for (let i = from; i < poses.length; i++) {
    world.step(poses[i], 1 / fps);
    each?.(i);
  }
  const { user, system } = process.cpuUsage(begin);
  return (user + system) / 1e6;
}

const frames = [];
let state, contacts = 0;
const half = Math.floor(poses.length / 2);
world.reset(poses[0]);
run(1, (i) => {
  frames.push(world.bodies());
  contacts += world.contacts().length;
  if (i === half) state = world.save();
});
const end = world.bodies();
world.load(state);
run(half + 1);
const again = world.bodies().every((x, i) => x === end[i]);
world.reset(poses[0]);
const seconds = run(1); // by now compiled to the end

const mistakes = [];
for (const mistake of [
  () => core.world(new Uint8Array(100)),
  () => world.setMass("moon", 1),
  () => world.step({ translation: [0, 0, NaN], rotations: new Float64Array(165) }, 1 / 30),
  () => world.reset({ translation: [0, 0, 0], rotations: [] }),
]) {
  try {
    mistake();
  } catch (error) {
    mistakes.push(error instanceof HalfPhysicsError ? `${error.status} ${error.message}` : `${error}`);
  }
}
writeFileSync(out, Buffer.concat(frames.map((f) => Buffer.from(f.buffer))));
const { version, jointNames } = core;
const { names, kinds, bodyNames } = world;
world.free();
console.log(JSON.stringify({
  version, jointNames, names, kinds, bodyNames, contacts, again, mistakes, framesPerSecond: (poses.length - 1) / seconds,
}));
