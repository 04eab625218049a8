// What the simulation of a page moves in viser's scene: bones of people and ghosts, objects, contacts.

const IDENTITY = [1, 0, 0, 0];
const FADE = [0.01, 0.03]; // a ghost appears between these distances from the body [m] (render/look.py)
const STEPS = 6; // in which its opacity changes
// Length of an arrow (viewer/contacts.py): up to 1 N, for ten times the force [m]; largest force [N].
const [SHORTEST, TENFOLD, LARGEST] = [0.06, 0.08, 1e4];

/** World frames of the joints of a pose, by forward kinematics: [place, turn] of each. */
function posed(person, translation, rotations) {
  const { parents } = data.play;
  const out = [];
  for (let j = 0; j < parents.length; j++) {
    const own = quaternion(rotations[3 * j], rotations[3 * j + 1], rotations[3 * j + 2]);
    const parent = parents[j];
    if (parent < 0) {
      out.push([add(person.pelvis, translation), own]);
      continue;
    }
    const [place, turn] = out[parent];
    out.push([add(place, turned(turn, add(person.rest[j], person.rest[parent], -1))), times(turn, own)]);
  }
  return out;
}

class FigureNodes {
  /** @param person One of `data.play.people`. */
  constructor(person) {
    this.person = person;
    this.steps = person.ghost.map(() => 0);
  }

  /** Moves body and ghost; `body` and `ghost` are [place, turn] of all joints. */
  show(body, ghost) {
    const messages = [];
    for (const piece of this.person.pieces) bones(messages, piece, body);
    this.fade(messages, body, ghost);
    this.person.ghost.forEach((part, k) => this.steps[k] && bones(messages, part, ghost));
    viser.messageQueue.push(...messages);
  }

  /** The parts of the ghost that coincide with the body fade out. */
  fade(messages, body, ghost) {
    const { tips } = this.person;
    const tip = ([place, turn], j) => add(place, turned(turn, tips[j]));
    this.person.ghost.forEach((part, k) => {
      const apart = Math.max(...part.of.map((j) => Math.max(
        Math.hypot(...add(body[j][0], ghost[j][0], -1)),
        Math.hypot(...add(tip(body[j], j), tip(ghost[j], j), -1)))));
      const x = Math.min(Math.max((apart - FADE[0]) / (FADE[1] - FADE[0]), 0), 1);
      const step = Math.round(STEPS * x * x * (3 - 2 * x));
      const before = this.steps[k];
      if (step === before) return;
      this.steps[k] = step;
      if (step) messages.push(update(part.node, { opacity: (data.play.ghostAlpha * step) / STEPS }));
      if (Boolean(step) !== Boolean(before)) messages.push(visibility(part.node, step > 0));
    });
  }
}

function bones(messages, { node: name, joints }, frames) {
  joints.forEach((joint, index) => {
    const which = { name, owner: "", bone_index: index };
    messages.push({ type: "SetBonePositionMessage", ...which, position: frames[joint][0] },
      { type: "SetBoneOrientationMessage", ...which, wxyz: frames[joint][1] });
  });
}

const update = (name, updates) => ({ type: "SceneNodeUpdateMessage", name, owner: "", updates });
const visibility = (name, visible) =>
  ({ type: "SetSceneNodeVisibilityMessage", name, owner: "", visible });

function placed(name, [position, wxyz]) {
  viser.messageQueue.push({ type: "SetPositionMessage", name, owner: "", position },
    { type: "SetOrientationMessage", name, owner: "", wxyz });
}

/** Points and arrows of the contacts of a frame, of each kind. */
class ContactNodes {
  constructor(kinds) {
    this.kinds = kinds;
    this.shown = new Set();
  }

  /** @param contacts [{kind, position, force}], force [N] on the part. */
  show(contacts) {
    for (const kind of this.kinds) {
      const mine = contacts.filter((one) => one.kind === kind.kind);
      const pushed = mine.filter((one) => Math.hypot(...one.force) > 0);
      this.batch(kind.point, mine.length, () => ({
        batched_positions: Float32Array.from(mine.flatMap((one) => one.position)),
        batched_wxyzs: Float32Array.from(mine.flatMap(() => IDENTITY)) }));
      this.batch(kind.arrow, pushed.length, () => ({ points: Float32Array.from(pushed.flatMap(arrow)) }));
    }
  }

  batch(name, count, values) {
    const was = this.shown.has(name);
    if (count) viser.messageQueue.push(update(name, values()));
    if (Boolean(count) === was) return;
    viser.messageQueue.push(visibility(name, count > 0));
    if (count) this.shown.add(name);
    else this.shown.delete(name);
  }
}

function arrow({ position, force }) {
  const size = Math.hypot(...force);
  const length = SHORTEST + TENFOLD * Math.log10(Math.min(Math.max(size, 1), LARGEST));
  return [...position, ...add(position, force, length / size)];
}

/** A contact where it is in the rest pose of its person, with the size of its force. */
function atRest(person, frames, { part, position, force }) {
  const [place, turn] = frames[part];
  const local = turned([turn[0], -turn[1], -turn[2], -turn[3]], add(position, place, -1));
  return [...add(person.rest[part], local), Math.hypot(...force)];
}
