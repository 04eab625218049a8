// Cameras of the page: presets, the first view, and a camera that follows the people.
//
// `data.track` has, for every frame, boxes in viser's world [m]: `low` and `high` of all people,
// their `middle`, the direction `left` of the first person, and `hands`.

const MARGIN = { body: 0.16, hands: 0.06 }; // around joints [m]
const FILLED = { home: 0.76, body: 0.8, hands: 0.7 }; // filled share of the window
const LEAST = 0.6; // least distance from the middle [m]
const LATE = 0.25; // time constant of following [s]
const ZOOM = 0.6; // time constant of the distance, where several people part or meet [s]

const add = (a, b, s = 1) => a.map((x, k) => x + s * b[k]);
const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.max(Math.hypot(...a), 1e-9));

function corners(low, high, margin) {
  const ends = [low.map((x) => x - margin), high.map((x) => x + margin)];
  return Array.from({ length: 8 }, (_, k) => [ends[k & 1][0], ends[(k >> 1) & 1][1], ends[k >> 2][2]]);
}

/** The nearest camera that has all points in the middle of the window: its position and target. */
function framed(points, direction, filled, shape) {
  const ahead = unit(direction).map((x) => -x);
  const right = unit(cross(ahead, [0, 0, 1]));
  const up = cross(right, ahead);
  const half = Math.tan(data.fov / 2);
  let back = 0;
  const middle = points.reduce((sum, p) => add(sum, p, 1 / points.length), [0, 0, 0]);
  for (const p of points) {
    const from = add(p, middle, -1);
    const depth = dot(from, ahead);
    back = Math.max(back, LEAST, Math.abs(dot(from, right)) / (filled * half * shape) - depth,
      Math.abs(dot(from, up)) / (filled * half) - depth);
  }
  return [add(middle, ahead, -back), middle];
}

const trackAt = (frame) => {
  const row = data.track[Math.min(frame, data.track.length - 1)];
  return { low: row.slice(0, 3), high: row.slice(3, 6), middle: row.slice(6, 9), left: row.slice(9, 12),
    hands: [row.slice(12, 15), row.slice(15, 18)] };
};

const windowShape = () => innerWidth / Math.max(innerHeight - barHeight(), 1);
const barHeight = () => parseFloat(getComputedStyle(document.documentElement)
  .getPropertyValue("--hp-bar")) || 60;

function presetView(name, frame) {
  const at = trackAt(frame);
  const left = unit([at.left[0], at.left[1], 0]);
  const front = cross(left, [0, 0, 1]);
  const up = [0, 0, 1];
  const direction = { Front: add(front, up, 0.15), Side: add(left, up, 0.15),
    Top: add(up, front, 0.02), Hands: add(add(front, left, 0.35), up, 0.5) }[name];
  const hands = name === "Hands";
  const box = hands ? at.hands : [at.low, at.high];
  const [margin, filled] = hands ? [MARGIN.hands, FILLED.hands] : [MARGIN.body, FILLED.body];
  return framed(corners(...box, margin), direction, filled, windowShape());
}

/** The first view: people at half of the height, from where the whole story is seen best. */
function homeView(frame) {
  const { first } = data;
  if (windowShape() < first.least) return peopleView(frame);
  const target = add(first.target, add(trackAt(frame).middle, trackAt(0).middle, -1));
  const away = add(first.position, first.target, -1);
  return [add(target, away, distanceAt(frame) / distanceAt(0)), target];
}

/** People in the middle of the window. */
function peopleView(frame) {
  const at = trackAt(frame);
  return framed(corners(at.low, at.high, MARGIN.body), data.direction, FILLED.home, windowShape());
}

/** The distance from which several people fill the window; 1 for one person. */
function distanceAt(frame) {
  if (data.people.length < 2) return 1;
  const [position, target] = peopleView(frame);
  return Math.hypot(...add(position, target, -1));
}

class PageCameras {
  constructor() {
    this.following = data.follow;
    this.middle = trackAt(0).middle;
    this.distance = distanceAt(0);
    this.last = performance.now();
  }

  look([position, target], frame) {
    const [p, t] = [toThree(position), toThree(target)];
    viser.cameraControl.setLookAt(p.x, p.y, p.z, t.x, t.y, t.z, false);
    this.middle = trackAt(frame).middle;
    this.distance = distanceAt(frame);
    redraw();
  }

  preset(name, frame) { this.look(presetView(name, frame), frame); }
  home(frame) { this.look(homeView(frame), frame); }

  /** The whole motion; the camera stays there. */
  everything(frame) {
    const ends = [0, 3].map((start) => [0, 1, 2].map((k) =>
      data.track.reduce((end, row) => (start ? Math.max : Math.min)(end, row[start + k]), start ? -1e9 : 1e9)));
    this.following = false;
    this.look(framed(corners(...ends, MARGIN.body), data.direction, FILLED.body, windowShape()), frame);
  }

  follow(frame) {
    this.following = !this.following;
    if (this.following) {
      const controls = viser.cameraControl;
      const seen = fromThree(controls.getTarget(viser.camera.position.clone()));
      const from = fromThree(controls.getPosition(viser.camera.position.clone()));
      const way = add(trackAt(frame).middle, seen, -1);
      this.look([add(from, way), add(seen, way)], frame);
    }
    say(this.following ? "The camera follows." : "The camera stays.", 1.5);
  }

  /** Moves along with the people; the angle stays, and for one person the distance. */
  tick(frame) {
    const now = performance.now();
    const passed = Math.min((now - this.last) / 1000, 0.25);
    this.last = now;
    const middle = trackAt(frame).middle;
    const distance = distanceAt(frame);
    if (!this.following) {
      [this.middle, this.distance] = [middle, distance];
      return;
    }
    const way = add(middle, this.middle, -1);
    const zoom = (distance / this.distance) ** -Math.expm1(-passed / ZOOM);
    if (Math.hypot(...way) < 1e-3 && Math.abs(zoom - 1) < 1e-4) return;
    this.distance *= zoom;
    const step = way.map((x) => x * -Math.expm1(-passed / LATE));
    this.middle = add(this.middle, step);
    const controls = viser.cameraControl;
    const from = fromThree(controls.getPosition(viser.camera.position.clone()));
    const target = fromThree(controls.getTarget(viser.camera.position.clone()));
    const orbit = add(from, target, -1).map((x) => x * zoom);
    const [p, t] = [toThree(add(add(target, orbit), step)), toThree(add(target, step))];
    controls.setLookAt(p.x, p.y, p.z, t.x, t.y, t.z, false);
    redraw();
  }
}
