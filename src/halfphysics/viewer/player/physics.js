// The simulation of a page: the core in WebAssembly, stepped at the motion's own rate. It is the clock of
// the bar, too. A slow machine plays in slow motion; no delay accumulates.

const MOST_STEPS = 4; // of a tick: a motion faster than the screen
const WINDOW = 60; // frames that the pace covers

class Physics {
  /** The world of `data.play`, at the first frame. */
  static async load(play) {
    const [wasm, world, translations, rotations] = await Promise.all([inflated(play.wasm),
      inflated(play.world), whole(play.translations, Float64Array), whole(play.rotations, Float64Array)]);
    const core = await HalfPhysics.load(wasm);
    return new Physics(core.world(world), play, translations, rotations);
  }

  constructor(world, play, translations, rotations) {
    Object.assign(this, { world, play, translations, rotations, frames: play.frames, fps: play.fps });
    Object.assign(this, { playing: false, speed: 1, loop: true, hold: false, live: true });
    this.before = () => {};
    this.changes = 0;
    this.turned = this.owned();
    this.restart();
  }

  // -- the world -----------------------------------------------------------------------------------

  /** Puts everybody at the first pose and objects at their start. */
  restart() {
    this.world.reset(this.pose(0));
    this.putStiffness(); // the core forgets it
    Object.assign(this, { index: 0, made: 0, times: [], due: -Infinity, seconds: 0 });
    this.read();
  }

  /** One frame. */
  make() {
    const dt = 1 / this.fps;
    if (this.index >= this.frames - 1 && this.loop && !this.hold) return this.restart();
    if (!this.hold) this.index = Math.min(this.index + 1, this.frames - 1);
    this.before(dt);
    const start = performance.now();
    this.world.step(this.pose(this.index), dt);
    const took = (performance.now() - start) / 1000;
    this.seconds += 0.1 * (took - this.seconds);
    this.made += 1;
    this.read();
  }

  read() {
    this.bodies = this.world.bodies();
    this.changes += 1;
  }

  /** What people are driven to at a frame, of each: translation (3), rotations (55 x 3). */
  pose(frame) {
    const people = this.play.people.length;
    const row = (values, k) => {
      const size = values.length / (this.frames * people);
      return values.subarray(size * (frame * people + k), size * (frame * people + k + 1));
    };
    return this.play.people.map((_, k) =>
      ({ translation: row(this.translations, k), rotations: row(this.rotations, k) }));
  }

  /** World frames of the joints of a person now: [place, turn] of each. */
  joints(k) {
    const count = this.play.parents.length;
    return this.play.parents.map((_, j) => this.frame(count * k + j));
  }

  /** The same of the reference. */
  reference(k) {
    const { translation, rotations } = this.pose(this.index)[k];
    return posed(this.play.people[k], translation, rotations);
  }

  /** [place, turn] of a body of the core. */
  frame(body) {
    const at = 7 * body;
    return [[...this.bodies.subarray(at, at + 3)], [...this.bodies.subarray(at + 3, at + 7)]];
  }

  /** Position and quaternion of an object. */
  place(object) {
    return this.frame(object.body);
  }

  /** The contacts of the last frame: [{person, part, kind, position, force}], force [N] on the part. */
  contacts() {
    const { statics, persons } = this.play;
    const kindOf = ({ person, other }) =>
      person < 0 ? 3 : other < statics ? 0 : other < persons ? 1 : 2; // KINDS of viewer/contacts.py
    return this.world.contacts().map((one) => ({ ...one, kind: kindOf(one) }));
  }

  /** Velocity of an object's origin [m/s] and angular velocity [rad/s], in the world. */
  velocity(object) {
    const { velocity, angularVelocity } = this.world.velocity(object.name);
    return { linear: [...velocity], angular: [...angularVelocity] };
  }

  setVelocity(object, linear, angular) {
    this.world.setVelocity(object.name, linear, angular);
  }

  // -- what can be turned --------------------------------------------------------------------------

  /** Sets stiffness, mass or friction now. */
  turn(what, value, object = null) {
    if (what === "stiffness") {
      this.turned.stiffness = value;
      return this.putStiffness();
    }
    this.turned[what][object.name] = value;
    if (what === "mass") this.world.setMass(object.name, value);
    else this.world.setFriction(object.name, value);
  }

  /** The values that the scenario has; stiffness null: that of each joint. */
  owned() {
    const free = this.play.objects.filter((one) => one.free);
    const of = (what) => Object.fromEntries(free.map((one) => [one.name, one[what]]));
    return { stiffness: null, mass: of("mass"), friction: of("friction") };
  }

  /** Everything as the scenario has it. Only what was changed is set: pairs may have values of their own. */
  own() {
    const own = this.owned();
    for (const object of this.play.objects.filter((one) => one.free)) {
      for (const what of ["mass", "friction"]) {
        if (this.turned[what][object.name] !== own[what][object.name]) {
          this.turn(what, own[what][object.name], object);
        }
      }
    }
    this.turned.stiffness = null;
    this.world.setStiffness(Float64Array.from(this.play.stiffness));
  }

  putStiffness() {
    const { stiffness } = this.turned;
    if (stiffness !== null) this.world.setStiffness(Float64Array.from(this.play.stiffnessUnit, (x) => stiffness * x));
  }

  // -- the clock of the bar ------------------------------------------------------------------------

  tick() {
    if (!this.playing) {
      this.due = -Infinity;
      this.times.length = 0;
      return;
    }
    const period = 1000 / (this.fps * this.speed);
    for (let k = 0; k < MOST_STEPS; k++) {
      const now = performance.now();
      if (now < this.due - 1) return;
      // A delay below one frame is made up for; a longer one is not.
      this.due = (this.due === -Infinity ? now : Math.max(this.due, now - period)) + period;
      this.times.push([now, period]);
      if (this.times.length > WINDOW) this.times.shift();
      this.make();
    }
  }

  /** The pace in words. */
  pace() {
    const made = `physics ${(1000 * this.seconds).toFixed(1)} of ${(1000 / this.fps).toFixed(0)} ms a frame`;
    if (!this.playing) return `Paused; ${made}`;
    if (this.times.length < WINDOW / 4) return made;
    const passed = this.times[this.times.length - 1][0] - this.times[0][0];
    const meant = this.times.slice(1).reduce((sum, [, period]) => sum + period, 0);
    const kept = Math.min(meant / Math.max(passed, 1e-9), 1);
    return kept < 0.95 ? `${made}; slow motion: ${Math.round(100 * kept * this.speed)} % of real time`
      : `${made}; ${Math.round(100 * this.speed)} % of real time`;
  }

  get duration() { return (this.frames - 1) / this.fps; }
  get time() { return this.index / this.fps; }
  get shown() { return this.time; }

  toggle() { this.playing = !this.playing; }
  setSpeed(speed) { this.speed = speed; }

  step(frames) {
    if (frames < 0) return say("A simulation cannot go back; Home starts it again.");
    this.playing = false;
    this.make();
  }

  seek(time) {
    if (time > 0) return say("A simulation cannot go to another time; Home starts it again.");
    this.restart();
  }
}
