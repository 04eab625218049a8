// Objects dragged by the pointer, as viewer/dragging.py does it: the ray of the pointer takes an object,
// and a critically damped pull sets its velocity before each frame. Contacts still stop the object.

const PULL = 20; // natural frequency of the pull [1/s]
const FASTEST = 12; // largest speed of a pulled object [m/s]
const NEAR = 22; // an object whose middle is this near to the pointer is taken, too [pixels]

/** The ray of a pointer event in the world: origin and unit direction. */
function rayOf(event) {
  const box = viser.canvas.getBoundingClientRect();
  const x = (2 * (event.clientX - box.left)) / box.width - 1;
  const y = 1 - (2 * (event.clientY - box.top)) / box.height;
  const at = (depth) => fromThree(viser.camera.position.clone().set(x, y, depth).unproject(viser.camera));
  const origin = at(-1);
  return { origin, direction: unit(add(at(0.5), origin, -1)) };
}

/** Whether a ray meets the sphere around a mesh. */
function near({ origin, direction }, { middle, radius }) {
  const to = add(middle, origin, -1);
  const along = Math.max(dot(to, direction), 0);
  return Math.hypot(...add(to, direction, -along)) <= radius;
}

/**
 * Distance along a ray to the first of the triangles; null: it meets none (Möller and Trumbore). In
 * plain numbers: large meshes have 100,000 triangles, and arrays of each would be ten times as slow.
 */
function metAt({ origin: [ox, oy, oz], direction: [dx, dy, dz] }, vertices, faces) {
  let first = null;
  for (let k = 0; k < faces.length; k += 3) {
    const [a, b, c] = [3 * faces[k], 3 * faces[k + 1], 3 * faces[k + 2]];
    const ax = vertices[a], ay = vertices[a + 1], az = vertices[a + 2];
    const bx = vertices[b] - ax, by = vertices[b + 1] - ay, bz = vertices[b + 2] - az;
    const cx = vertices[c] - ax, cy = vertices[c + 1] - ay, cz = vertices[c + 2] - az;
    const px = dy * cz - dz * cy, py = dz * cx - dx * cz, pz = dx * cy - dy * cx;
    const scale = bx * px + by * py + bz * pz;
    if (Math.abs(scale) < 1e-14) continue;
    const fx = ox - ax, fy = oy - ay, fz = oz - az;
    const u = (fx * px + fy * py + fz * pz) / scale;
    if (u < 0 || u > 1) continue;
    const qx = fy * bz - fz * by, qy = fz * bx - fx * bz, qz = fx * by - fy * bx;
    const v = (dx * qx + dy * qy + dz * qz) / scale;
    if (v < 0 || u + v > 1) continue;
    const t = (cx * qx + cy * qy + cz * qz) / scale;
    if (t > 0 && (first === null || t < first)) first = t;
  }
  return first;
}

/** A point on the screen [pixels]; null: it is behind the camera. */
function onScreen(point) {
  const box = viser.canvas.getBoundingClientRect();
  const place = toThree(point).project(viser.camera);
  if (place.z > 1) return null;
  return [box.left + ((place.x + 1) / 2) * box.width, box.top + ((1 - place.y) / 2) * box.height];
}

class Pointer {
  /** @param physics The simulation. @param objects Of `data.play.objects`, those that move freely. */
  constructor(physics, objects) {
    Object.assign(this, { physics, objects, drag: null });
    const listen = (name, act) => addEventListener(name, act, { capture: true });
    listen("pointerdown", (event) => this.take(event));
    listen("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) listen(end, (event) => this.letGo(event));
  }

  /** The object under the pointer and where the ray meets it; null: there is none. */
  under(event) {
    const ray = rayOf(event);
    let found = null;
    for (const object of this.objects) {
      const [position, turn] = this.physics.place(object);
      const back = [turn[0], -turn[1], -turn[2], -turn[3]];
      const own = { origin: turned(back, add(ray.origin, position, -1)),
        direction: turned(back, ray.direction) };
      const mesh = meshOf(object.node);
      let far = mesh && (near(own, mesh) ? metAt(own, mesh.vertices, mesh.faces) : null);
      if (far === null || far === undefined) far = this.nearly(event, ray, position);
      if (far !== null && (!found || far < found.far)) found = { object, far };
    }
    return found && { ...found, grip: add(ray.origin, ray.direction, found.far) };
  }

  nearly(event, ray, position) {
    const place = onScreen(position);
    if (!place || Math.hypot(place[0] - event.clientX, place[1] - event.clientY) > NEAR) return null;
    return dot(add(position, ray.origin, -1), ray.direction);
  }

  take(event) {
    if (event.button || event.target !== viser.canvas || this.drag) return;
    const found = this.under(event);
    if (!found) return;
    event.stopImmediatePropagation(); // the camera stays
    event.preventDefault();
    const [position] = this.physics.place(found.object);
    this.drag = { id: event.pointerId, object: found.object, grip: found.grip, pointer: found.grip,
      offset: add(position, found.grip, -1), normal: rayOf(event).direction };
    document.documentElement.style.cursor = viser.canvas.style.cursor = "grabbing";
  }

  move(event) {
    const { drag } = this;
    if (!drag) {
      if (event.pointerType === "mouse" && event.target === viser.canvas && !event.buttons) this.hover(event);
      return;
    }
    if (event.pointerId !== drag.id) return;
    event.stopImmediatePropagation();
    const { origin, direction } = rayOf(event);
    const along = dot(direction, drag.normal);
    if (along < 0.05) return;
    drag.pointer = add(origin, direction, dot(add(drag.grip, origin, -1), drag.normal) / along);
  }

  /** Shows whether something can be taken, once a picture: a mouse may move more often. */
  hover(event) {
    if (!this.hovered) {
      requestAnimationFrame(() => {
        if (!this.drag) viser.canvas.style.cursor = this.under(this.hovered) ? "grab" : "";
        this.hovered = null;
      });
    }
    this.hovered = event;
  }

  letGo(event) {
    if (!this.drag || event.pointerId !== this.drag.id) return;
    event.stopImmediatePropagation();
    this.drag = null;
    document.documentElement.style.cursor = viser.canvas.style.cursor = "";
  }

  /** Sets the velocity of the dragged object for the next frame, `dt` [s] long. */
  pull(dt) {
    const { drag, physics } = this;
    if (!drag) return;
    const [position] = physics.place(drag.object);
    const { linear, angular } = physics.velocity(drag.object);
    // Gravity adds to the velocity during a frame; half of that is the mean error in velocity.
    const half = physics.play.gravity.map((g) => 0.5 * dt * g);
    const off = add(position, add(drag.pointer, drag.offset), -1);
    const decay = Math.exp(-PULL * dt);
    const drift = add(add(linear, half, -1), off, PULL);
    const later = add(off, drift, dt).map((x) => x * decay);
    let wanted = add(add(later, off, -1).map((x) => x / dt), half, -1);
    const fast = Math.hypot(...wanted);
    if (fast > FASTEST) wanted = wanted.map((x) => (x * FASTEST) / fast);
    physics.setVelocity(drag.object, wanted, angular.map((x) => x * decay));
  }
}

/** Vertices and faces of a node's mesh, and a sphere around it, in the node's frame; undefined: it is not drawn yet. */
function meshOf(name) {
  const known = meshOf.known.get(name);
  if (known) return known;
  let found;
  const object = node(name);
  if (object) {
    object.traverse((part) => {
      const index = part.isMesh && part.geometry.getIndex();
      if (index) found ||= { vertices: part.geometry.getAttribute("position").array, faces: index.array };
    });
  }
  if (found) meshOf.known.set(name, Object.assign(found, sphere(found.vertices)));
  return found;
}
meshOf.known = new Map();

/** A sphere around points: about the middle of their box. */
function sphere(points) {
  const [low, high] = [[0, 0, 0].fill(Infinity), [0, 0, 0].fill(-Infinity)];
  for (let k = 0; k < points.length; k++) {
    low[k % 3] = Math.min(low[k % 3], points[k]);
    high[k % 3] = Math.max(high[k % 3], points[k]);
  }
  const middle = low.map((x, k) => (x + high[k]) / 2);
  let radius = 0;
  for (let k = 0; k < points.length; k += 3) {
    radius = Math.max(radius, Math.hypot(points[k] - middle[0], points[k + 1] - middle[1], points[k + 2] - middle[2]));
  }
  return { middle, radius };
}
