// Further people of a page, from files that are dropped onto it: results and motions of the SMPL
// family, posed here with the skin of the page's first person.

const FPS_KEYS = ["meta/fps", "mocap_frame_rate", "mocap_framerate", "mocap_frame_rates", "fps"];
const APART = 0.6; // nearer people are moved aside at the start [m]
const ASIDE = 0.9; // by so much [m]
const COLORS = [[150, 176, 205], [201, 160, 150], [156, 189, 150], [189, 170, 208]];

/** The people of an archive: [{fps, translation, rotations}], rotations (T, 55, 3) axis-angle. */
async function peopleIn(archive) {
  const get = async (name) => (archive.has(name) ? archive.get(name)() : null);
  let fps = null;
  for (const key of FPS_KEYS) fps ||= (await get(key))?.values[0];
  const found = [];
  let said = null;
  for (let k = 0; ; k++) {
    const prefix = k ? `person/${k}/` : "meta/";
    const [translation, rotations] = [await get(`${prefix}translation`), await get(`${prefix}rotations`)];
    if (!translation || !rotations) break;
    said ||= JSON.parse((await get("meta/people"))?.text || "[]");
    found.push({ translation: translation.values, rotations: rotations.values, axes: said[k]?.axes });
  }
  if (!found.length) {
    const [trans, poses] = [await get("trans"), await get("poses")];
    if (!trans || !poses) {
      throw new NpzError("it has neither the arrays of a result nor 'trans' and 'poses'");
    }
    found.push({ translation: trans.values, rotations: toSmplx(poses) });
  }
  if (!fps) throw new NpzError("it does not say its frames per second");
  return found.map((one) => ({ ...one, fps, frames: one.translation.length / 3 }));
}

/** Poses of SMPL (72), SMPL-H (156) or SMPL-X (165 columns) as the 55 joints of SMPL-X. */
function toSmplx({ shape, values }) {
  const frames = shape[0];
  const columns = values.length / frames;
  if (columns === 165) return values;
  if (columns !== 156 && columns !== 72 && columns !== 66) {
    throw new NpzError(`its poses have ${columns} columns; 72, 156 or 165 are known`);
  }
  const out = new Float64Array(frames * 165);
  for (let t = 0; t < frames; t++) {
    const row = values.subarray(t * columns, (t + 1) * columns);
    out.set(row.subarray(0, 66), t * 165);
    if (columns === 156) out.set(row.subarray(66), t * 165 + 75);
  }
  return out;
}

const times = (a, b) => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];

function turned(q, v) {
  const u = [q[1], q[2], q[3]];
  const t = cross(u, v).map((x) => 2 * x);
  return add(add(v, t, q[0]), cross(u, t));
}

function quaternion(x, y, z) {
  const angle = Math.hypot(x, y, z);
  const s = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), x * s, y * s, z * s];
}

class FurtherPerson {
  /** @param motion Of `peopleIn`. @param body `data.body`, unpacked. @param like Props of a mesh. */
  constructor(motion, body, like, number) {
    Object.assign(this, { motion, body, shown: -1 });
    this.name = `/dropped/${number}`;
    this.offset = [0, 0, 0];
    // The rest pose of a motion from a y-up file is turned into the world by its axes.
    this.rest = motion.axes ? motion.axes.map((row) => dot(row, body.joints[0])) : body.joints[0];
    const count = body.parents.length;
    viser.messageQueue.push({ type: "SkinnedMeshMessage", name: this.name, owner: "", virtual: false,
      props: { ...like, vertices: body.vertices, faces: body.faces,
        color: COLORS[number % COLORS.length],
        bone_wxyzs: Float32Array.from({ length: 4 * count }, (_, k) => (k % 4 ? 0 : 1)),
        bone_positions: Float32Array.from(body.joints.flat()),
        skin_indices: body.indices, skin_weights: body.weights } });
  }

  get seconds() { return (this.motion.frames - 1) / this.motion.fps; }

  pelvis(frame) {
    return add(add(this.rest, [...this.motion.translation.subarray(3 * frame, 3 * frame + 3)]),
      this.offset);
  }

  show(time) {
    const frame = Math.min(Math.floor(time * this.motion.fps + 1e-6), this.motion.frames - 1);
    if (frame === this.shown) return;
    this.shown = frame;
    const { parents, joints } = this.body;
    const [turns, places] = [[], []];
    const messages = [];
    for (let j = 0; j < parents.length; j++) {
      const at = (frame * parents.length + j) * 3;
      const own = quaternion(...this.motion.rotations.subarray(at, at + 3));
      const parent = parents[j];
      turns.push(parent < 0 ? own : times(turns[parent], own));
      places.push(parent < 0 ? this.pelvis(frame)
        : add(places[parent], turned(turns[parent], add(joints[j], joints[parent], -1))));
      const which = { name: this.name, owner: "", bone_index: j };
      messages.push({ type: "SetBonePositionMessage", ...which, position: places[j] },
        { type: "SetBoneOrientationMessage", ...which, wxyz: turns[j] });
    }
    viser.messageQueue.push(...messages);
    redraw();
  }
}
