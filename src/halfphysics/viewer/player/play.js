// A page with physics: no server and no recording, the core runs here (viewer/play_page.py).

/** The marks of a simulation so far: of each kind of contact, the largest force by frame. */
class LiveMarks {
  constructor(kinds, frames) {
    this.kinds = kinds;
    this.force = kinds.map(() => new Float32Array(frames));
    this.late = true;
    this.marked = 0;
  }

  add(frame, contacts) {
    this.kinds.forEach(({ kind }, k) => {
      const most = Math.max(0, ...contacts.filter((one) => one.kind === kind)
        .map((one) => Math.hypot(...one.force)));
      this.late ||= most !== this.force[k][frame];
      this.force[k][frame] = most;
    });
  }

  /** Shows new marks, twice a second at most. */
  refresh(bar) {
    const now = performance.now();
    if (!this.late || now - this.marked < 500) return;
    this.late = false;
    this.marked = now;
    bar.setMarks(this.rows());
  }

  rows() {
    const { fps } = data;
    return this.kinds.map(({ label, color }, k) => {
      const marks = [];
      let start = null;
      const force = this.force[k];
      for (let frame = 0; frame <= force.length; frame++) {
        const touches = frame < force.length && force[frame] >= 1;
        if (touches && start === null) start = frame;
        if (touches || start === null) continue;
        const most = Math.max(...force.subarray(start, frame));
        marks.push([Math.max(start - 1, 0) / fps, (frame - 1) / fps, `up to ${most.toFixed(0)} N`]);
        start = null;
      }
      return { label, color, marks };
    });
  }
}

/** Where the people are now, as a row of `data.track`. */
function trackNow(people) {
  const boxes = (frames) => [0, 1, 2].map((k) => Math.min(...frames.map(([place]) => place[k])))
    .concat([0, 1, 2].map((k) => Math.max(...frames.map(([place]) => place[k]))));
  const all = people.flat();
  const { hands, hips } = data.play;
  const middle = [0, 1, 2].map((k) => people.reduce((sum, one) => sum + one[0][0][k], 0) / people.length);
  const left = unit(add(people[0][hips[0]][0], people[0][hips[1]][0], -1));
  return [...boxes(all), ...middle, ...left, ...boxes(people.flatMap((one) => hands.map((j) => one[j])))];
}

/** Draws the state of the simulation. */
class PlayScene {
  constructor(physics) {
    this.physics = physics;
    this.paint = new SkinForces(data.ramp);
    this.nodes = new ContactNodes(data.play.kinds);
    this.figures = data.play.people.map((person) => new FigureNodes(person));
    this.shown = -1;
  }

  /** Draws it if it is new. */
  refresh() {
    const { changes } = this.physics;
    if (this.shown === changes || !data.people.every(node)) return;
    this.shown = changes;
    this.show();
    redraw();
  }

  show() {
    const { physics } = this;
    const { play } = data;
    const people = play.people.map((_, k) => physics.joints(k));
    people.forEach((frames, k) => this.figures[k].show(frames, physics.reference(k)));
    for (const object of play.objects) placed(object.node, physics.place(object));
    this.nodes.show(physics.contacts);
    data.track[1] = trackNow(people);
    placed(play.subject, [data.track[1].slice(6, 9), IDENTITY]);
    people.forEach((frames, k) => this.paint.show(data.people[k], physics.contacts
      .filter((one) => one.person === k && Math.hypot(...one.force) >= 1)
      .map((one) => atRest(play.people[k], frames, one))));
  }

  layer(layer, on) {
    if (layer.id === "skin") this.paint.on = on;
    for (const name of layer.nodes) setVisible(name, on);
    this.shown = -1;
    redraw();
  }
}

async function startPlay(packed) {
  data = packed;
  data.track = [...data.track, data.track[0]]; // the first frame, and now
  aimFirst();
  try {
    const physics = await Physics.load(packed.play);
    whenLoaded(() => playPage(physics));
  } catch (error) {
    console.error(error);
    whenLoaded(() => say(`The physics does not start here: ${error.message}`, 60));
  }
}

function playPage(physics) {
  const cameras = new PageCameras();
  const scene = new PlayScene(physics);
  const marks = new LiveMarks(data.play.kinds, physics.frames);
  const pointer = new Pointer(physics, data.play.objects.filter((one) => one.free));
  physics.held = () => Boolean(pointer.drag);
  physics.before = (dt) => pointer.pull(dt);
  physics.after = () => marks.add(physics.index, physics.contacts);
  const bar = new Bar(physics);
  const following = () => panel.follow.classList.toggle("hp-on", cameras.following);
  const follow = () => {
    cameras.follow(1);
    following();
  };
  const panel = new PagePanel({
    layer: (layer, on) => scene.layer(layer, on),
    camera(name) {
      if (name === "Everything") cameras.everything(1);
      else if (name === "First") cameras.home(1);
      else cameras.preset(name, 1);
      following();
    },
    follow,
  });
  const knobs = new Knobs(physics);
  panel.folded.prepend(knobs.element);
  following();
  document.body.append(bar.element, panel.element);
  bar.setMarks(marks.rows());
  listenToKeys({ ...commonKeys(physics, { next: () => say("There is nothing to compare: this runs now.") }),
    f: follow, 0: () => cameras.home(1),
    ...Object.fromEntries(PRESETS.map((name, k) => [`${k + 1}`, () => cameras.preset(name, 1)])) });
  whenReady(() => {
    const begin = () => (physics.playing = true);
    if (pictureStands()) addEventListener("first-picture", begin, { once: true });
    else begin();
    frameLoop(() => {
      physics.tick();
      scene.refresh();
      marks.refresh(bar);
      cameras.tick(1);
      bar.refresh();
      knobs.status.textContent = physics.pace();
    });
  });
  window.halfphysics = { physics, cameras, pointer, knobs, clock: physics };
}
