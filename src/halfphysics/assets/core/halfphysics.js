// halfphysics in JavaScript: the native core, compiled to WebAssembly, for browsers and node (docs/c-api.md).
//
//     const core = await HalfPhysics.load(wasmBytes);
//     const world = core.world(worldFileBytes); // halfphysics.compile_world, Simulator.save_world
//     world.reset(pose); // { translation: [x, y, z], rotations: 55 x 3 numbers }; several people: an array
//     world.step(pose, 1 / 30);
//     world.bodies(); // Float64Array, 7 numbers per body: position [m], quaternion w, x, y, z
//
// Everything runs where it is called, synchronously, without a server or threads. Types: halfphysics.d.ts.

const JOINTS = 55;
const CONTACT_BYTES = 120; // hp_contact
const POSE = 3 + 3 * JOINTS;

/** A call of the core that failed; `status` is its hp_status. */
class HalfPhysicsError extends Error {
  constructor(message, status) {
    super(message);
    this.name = "HalfPhysicsError";
    this.status = status;
  }
}

/** What the module asks of its surroundings: it has no files, only a clock and the growth of its memory. */
function surroundings(module, memory) {
  const given = {
    emscripten_notify_memory_growth: () => undefined,
    clock_time_get: (clock, precision, at) => {
      new DataView(memory().buffer).setBigInt64(at, BigInt(Math.round(1e6 * performance.now())), true);
      return 0;
    },
  };
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    const missing = () => {
      throw new Error(`halfphysics: the core stopped (${name})`);
    };
    (imports[from] ??= {})[name] = given[name] ?? missing;
  }
  return imports;
}

async function compiled(source) {
  if (source instanceof WebAssembly.Module) return source;
  if (typeof source === "string" || source instanceof URL) {
    const file = typeof process === "object" && `${source}`.startsWith("file:");  // node fetches no files
    source = file ? await (await import("node:fs/promises")).readFile(new URL(source)) : await fetch(source);
  }
  if (typeof Response !== "undefined" && source instanceof Response) source = await source.arrayBuffer();
  return WebAssembly.compile(source);
}

/** The core: makes worlds. */
class HalfPhysics {
  /** From the bytes of halfphysics.wasm, its address, a Response or a compiled module. */
  static async load(source) {
    const module = await compiled(source);
    const imports = surroundings(module, () => instance.exports.memory);
    const instance = await WebAssembly.instantiate(module, imports);
    return new HalfPhysics(instance.exports);
  }

  constructor(calls) {
    this._calls = calls;
    calls._initialize?.();
    this.version = this._text(calls.hp_version());
    this.worldFileVersion = calls.hp_world_file_version();
    this.jointNames = Array.from({ length: JOINTS }, (_, i) => this._text(calls.hp_joint_name(i)));
  }

  /** A world from the bytes of a world file. Throws HalfPhysicsError. */
  world(bytes) {
    const data = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    const at = this._room(data.length);
    try {
      this._bytes(at, data.length).set(data);
      const handle = this._calls.hp_world_load(at, data.length);
      if (handle === 0) throw new HalfPhysicsError(this._text(this._calls.hp_error()), 2);
      return new World(this, handle);
    } finally {
      this._calls.free(at);
    }
  }

  // Memory may move whenever the core has taken more of it: views are made anew each time.
  _bytes(at, count) {
    return new Uint8Array(this._calls.memory.buffer, at, count);
  }

  _doubles(at, count) {
    return new Float64Array(this._calls.memory.buffer, at, count);
  }

  _room(bytes) {
    const at = this._calls.malloc(Math.max(bytes, 8));
    if (at === 0) throw new HalfPhysicsError("there is not enough memory", 6);
    return at;
  }

  _text(at) {
    if (at === 0) return null;
    const all = new Uint8Array(this._calls.memory.buffer);
    return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
  }
}

function check(values, count, name) {
  if (values?.length === count) return values;
  throw new HalfPhysicsError(`${name}: found ${values?.length ?? values}, expected ${count} numbers`, 1);
}

/** People and a scene that are simulated; HalfPhysics.world makes one. Methods throw HalfPhysicsError. */
class World {
  constructor(core, handle) {
    const calls = core._calls;
    this._core = core;
    this._handle = handle;
    this.people = calls.hp_person_count(handle);
    const list = (count, name) => Array.from({ length: count }, (_, i) => core._text(name(handle, i)));
    this.names = list(calls.hp_name_count(handle), calls.hp_name);
    this.kinds = this.names.map((_, i) => ["static", "object", "link", "person"][calls.hp_kind_of(handle, i)]);
    this.bodyNames = list(calls.hp_body_count(handle), calls.hp_body_name);
    this.jointNames = list(calls.hp_joint_count(handle), calls.hp_hinge_name);
    // Poses of all people, then whatever comes out: bodies, a pose, a few numbers.
    this._poses = core._room(8 * POSE * this.people);
    this._out = core._room(8 * Math.max(7 * this.bodyNames.length, POSE, 16));
    this._contactsAt = 0;
    this._contactsRoom = 0;
  }

  /** Puts the people at a pose and objects at their start. */
  reset(pose) {
    this._put(pose);
    this._call("hp_reset", this._poses, this._poses + 24 * this.people);
  }

  /** Drives the people towards a pose for one frame of `dt` seconds. */
  step(pose, dt) {
    this._put(pose);
    this._call("hp_step", this._poses, this._poses + 24 * this.people, dt);
  }

  /** The corrected pose of a person. */
  pose(person = 0) {
    this._call("hp_get_pose", person, this._out, this._out + 24);
    return { translation: this._read(3), rotations: this._read(POSE - 3, 24) };
  }

  /** Positions and quaternions, 7 numbers per body in the order of `bodyNames`; into `out` where it is given. */
  bodies(out = new Float64Array(7 * this.bodyNames.length)) {
    check(out, 7 * this.bodyNames.length, "bodies");
    this._call("hp_get_bodies", this._out);
    out.set(this._core._doubles(this._out, out.length));
    return out;
  }

  /** Position and quaternion of an object or a link. */
  object(name) {
    this._named("hp_get_object", name, this._out, this._out + 24);
    return { position: this._read(3), quaternion: this._read(4, 24) };
  }

  /** Velocity of an object's origin and its angular velocity, in the world. */
  velocity(name) {
    this._named("hp_get_velocity", name, this._out, this._out + 24);
    return { velocity: this._read(3), angularVelocity: this._read(3, 24) };
  }

  /** Value of a joint of an articulated object, by its name: 1 number, 4 of a ball, 7 of a free joint. */
  joint(name) {
    this._call("hp_get_joint", this.jointNames.indexOf(name), this._out, this._out + 56);
    const count = new Int32Array(this._core._calls.memory.buffer, this._out + 56, 1)[0];
    return this._read(count);
  }

  /** Contacts of the last frame. */
  contacts() {
    const count = this._sized("hp_get_contacts", this._contactsAt, this._contactsRoom);
    if (count > this._contactsRoom) {
      this._core._calls.free(this._contactsAt);
      this._contactsRoom = 2 * count;
      this._contactsAt = this._core._room(CONTACT_BYTES * this._contactsRoom);
      this._sized("hp_get_contacts", this._contactsAt, this._contactsRoom);
    }
    const view = new DataView(this._core._calls.memory.buffer);
    return Array.from({ length: count }, (_, i) => {
      const at = this._contactsAt + CONTACT_BYTES * i;
      const whole = (k) => view.getInt32(at + 4 * k, true);
      const three = (k) => [0, 8, 16].map((d) => view.getFloat64(at + 24 + 24 * k + d, true));
      return {
        person: whole(0), part: whole(1), subject: whole(2), other: whole(3), otherPart: whole(4),
        position: three(0), normal: three(1), impulse: three(2), force: three(3),
      };
    });
  }

  /** Minimum distance of the people from static geometry [m]; Infinity beyond what the settings ask for. */
  clearance() {
    this._call("hp_get_clearance", this._out);
    return this._read(1)[0];
  }

  /** Time by which blocked steps of the last frame were shortened [s]. */
  lostTime() {
    this._call("hp_get_lost_time", this._out);
    return this._read(1)[0];
  }

  /** Stiffness of the joints from the next step on: a number or 55 of them; of all people or of one. */
  setStiffness(stiffness, person = -1) {
    const values = typeof stiffness === "number" ? new Array(JOINTS).fill(stiffness) : stiffness;
    this._write(check(values, JOINTS, "setStiffness"));
    this._call("hp_set_stiffness", person, this._out);
  }

  /** Mass of a free object [kg]; its inertia changes by the same factor. */
  setMass(name, kg) {
    this._named("hp_set_mass", name, kg);
  }

  mass(name) {
    this._named("hp_get_mass", name, this._out);
    return this._read(1)[0];
  }

  /** Friction of an item or a person with all others, but for pairs that the scene has set apart. */
  setFriction(name, friction) {
    this._named("hp_set_friction", name, friction);
  }

  /** Gives an object a velocity [m/s]; without an angular velocity [rad/s] that stays as it is. */
  setVelocity(name, velocity, angularVelocity = null) {
    this._write(check(velocity, 3, "setVelocity"));
    if (angularVelocity) this._write(check(angularVelocity, 3, "setVelocity"), 24);
    this._named("hp_set_velocity", name, this._out, angularVelocity ? this._out + 24 : 0);
  }

  /** Pushes an object by an impulse [N s], at a point of the world or at its centre of mass. */
  applyImpulse(name, impulse, point = null) {
    this._write(check(impulse, 3, "applyImpulse"));
    if (point) this._write(check(point, 3, "applyImpulse"), 24);
    this._named("hp_apply_impulse", name, this._out, point ? this._out + 24 : 0);
  }

  /** The axes (3 x 3, by rows) in which a person's poses are given. */
  setAxes(axes, person = 0) {
    this._write(check(axes, 9, "setAxes"));
    this._call("hp_set_axes", person, this._out);
  }

  /** Everything that the simulation remembers, for `load` of a world of the same file. */
  save() {
    const size = this._sized("hp_save", 0, 0);
    const at = this._core._room(size);
    try {
      this._sized("hp_save", at, size);
      return this._core._bytes(at, size).slice();
    } finally {
      this._core._calls.free(at);
    }
  }

  load(state) {
    const at = this._core._room(state.length);
    try {
      this._core._bytes(at, state.length).set(state);
      this._call("hp_load", at, state.length);
    } finally {
      this._core._calls.free(at);
    }
  }

  /** Gives the memory back; the world cannot be used any longer. */
  free() {
    const { free, hp_world_free } = this._core._calls;
    for (const at of [this._poses, this._out, this._contactsAt]) free(at);
    hp_world_free(this._handle);
    this._handle = this._poses = this._out = this._contactsAt = 0;
  }

  // -- inside ----------------------------------------------------------------------------------

  _call(name, ...given) {
    if (this._handle === 0) throw new HalfPhysicsError("the world has been freed", 1);
    const status = this._core._calls[name](this._handle, ...given);
    if (status !== 0) throw new HalfPhysicsError(this._core._text(this._core._calls.hp_error()), status);
  }

  // A call whose first argument is a name.
  _named(name, item, ...given) {
    const text = new TextEncoder().encode(`${item}\0`);
    const at = this._core._room(text.length);
    try {
      this._core._bytes(at, text.length).set(text);
      this._call(name, at, ...given);
    } finally {
      this._core._calls.free(at);
    }
  }

  // A call that writes into memory with so much room, and gives its count through a pointer.
  _sized(name, at, room) {
    this._call(name, at, room, this._out);
    return new Uint32Array(this._core._calls.memory.buffer, this._out, 1)[0];
  }

  _read(count, offset = 0) {
    return this._core._doubles(this._out + offset, count).slice();
  }

  _write(values, offset = 0) {
    this._core._doubles(this._out + offset, values.length).set(values);
  }

  _put(pose) {
    const poses = Array.isArray(pose) ? pose : [pose];
    if (poses.length !== this.people)
      throw new HalfPhysicsError(`pose: found ${poses.length}, expected one per person, ${this.people}`, 1);
    const room = this._core._doubles(this._poses, POSE * this.people);
    poses.forEach((one, i) => {
      room.set(check(one.translation, 3, "translation"), 3 * i);
      room.set(check(one.rotations, 3 * JOINTS, "rotations"), 3 * this.people + 3 * JOINTS * i);
    });
  }
}

export { HalfPhysics, HalfPhysicsError };
