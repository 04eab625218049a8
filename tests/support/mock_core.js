// A stand-in for the core's package in tests of the page: people are where they are told, objects fall
// onto the floor and keep the velocity that they are given. It has the methods that the page uses.

class MockWorld {
  constructor(play) {
    this.play = play;
    this.calls = [];
  }

  reset(...pose) {
    this.pose = pose;
    this.objects = this.play.objects.map((one) => ({ ...one, at: [...one.start], velocity: [0, 0, 0] }));
  }

  step(translations, rotations, dt) {
    this.pose = [translations, rotations];
    for (const one of this.objects) {
      one.velocity = add(one.velocity, this.play.gravity, dt);
      one.at = add(one.at, one.velocity, dt);
      if (one.at[2] < 0.11) [one.at[2], one.velocity[2]] = [0.11, 0];
    }
  }

  bodies() {
    const [translations, rotations] = this.pose;
    const frames = this.play.people.flatMap((person, k) =>
      posed(person, [...translations.subarray(3 * k, 3 * k + 3)], rotations.subarray(165 * k, 165 * (k + 1))));
    for (const one of this.objects) frames.push([one.at, IDENTITY]);
    return Float64Array.from(frames.flat(2));
  }

  contacts() { return []; }
  velocity(name) {
    return { linear: this.objects.find((one) => one.name === name).velocity, angular: [0, 0, 0] };
  }
  setVelocity(name, linear) { this.objects.find((one) => one.name === name).velocity = linear; }
  setStiffness(value) { this.calls.push(["stiffness", value]); }
  setMass(name, value) { this.calls.push(["mass", name, value]); }
  setFriction(name, value) { this.calls.push(["friction", name, value]); }
}

const HalfPhysics = { load: async () => ({ world: () => new MockWorld(data.play) }) };
