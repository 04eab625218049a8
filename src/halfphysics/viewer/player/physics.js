// The simulation of a page: the core in WebAssembly, stepped at the motion's own rate. It is the clock of
// the bar, too. Where drawing is slow, several frames are made per picture; where physics is slow, it is
// slow motion, and no delay accumulates.

const DEBT = 1000; // a longer delay is not made up for [ms]
const BUDGET = 60; // physics per picture, or as long as all else takes [ms]
const WINDOW = 60; // frames that the pace covers

class Physics {
  /** The world of `data.play`, at the first frame. */
  static async load(play) {
    const [wasm, world, translations, rotations] = await Promise.all([inflated(play.wasm),
      inflated(play.world), whole(play.translations, Float64Array), whole(play.rotations, Float64Array)]);
    const core = await HalfPhysics.load(wasm);
    return new Physics(core.world(world), play, translations, rotations);
  }

  /**
   * Attributes: `index`: the frame of the reference; `made`: frames since the start; `bodies`: of the core, 7 numbers
   * each; `contacts`: of the last frame, of the core with their `kind`; `changes`: how often these are new.
   */
  constructor(world, play, translations, rotations) {
    Object.assign(this, { world, play, translations, rotations, frames: play.frames, fps: play.fps });
    Object.assign(this, { playing: false, speed: 1, loop: true, hold: false, live: true });
    this.before = this.after = () => {}; // called before a frame with its length [s], and after it
    this.held = () => false; // whether a pointer holds something: the loop waits for it
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
    if (this.index >= this.frames - 1 && this.loop && !this.hold && !this.held()) return this.restart();
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
    this.contacts = this.world.contacts().map((one) => ({ ...one, kind: this.kindOf(one) }));
    this.changes += 1;
    this.after();
  }

  /** The kind of a contact, an index into KINDS of viewer/contacts.py. */
  kindOf({ person, other }) {
    if (person < 0) return 3;
    if (other >= this.play.persons) return 2;
    return other < this.play.statics ? 0 : 1;
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
    const begun = performance.now();
    const budget = Math.max(BUDGET, begun - (this.ended ?? begun));
    // Over a second between two pictures: the tab was hidden, and goes on where it was.
    if (this.due === -Infinity || begun - this.ended > DEBT) this.due = begun;
    this.due = Math.max(this.due, begun - DEBT);
    for (let now = begun; now >= this.due - 1 && now < begun + budget; now = performance.now()) {
      this.due += period;
      this.times.push([now, period]);
      if (this.times.length > WINDOW) this.times.shift();
      this.make();
      if (!this.index) break; // at the start again: one picture of it
    }
    this.ended = performance.now();
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
