// Dents of soft things (viewer/dents.py): the depth of every vertex in a frame is the product of the
// frame's weights and a few rows of depths; a vertex goes its own way by its depth.

const WAY_GRAIN = 2 ** -12;

class Dents {
  /** @param given `data.dents`, unpacked by `Dents.load`. */
  constructor(given) {
    this.things = given;
    this.shown = -1;
  }

  static async load(given) {
    return new Dents(await Promise.all((given || []).map(async (one) => {
      const at = await whole(one.at, Int32Array);
      for (let k = 1; k < at.length; k++) at[k] += at[k - 1];
      return { node: one.node, count: one.count, rows: one.rows, unit: one.unit / 32767, at,
        way: Float32Array.from(await whole(one.way, Int16Array), (x) => x * WAY_GRAIN),
        depth: await whole(one.depth, Int16Array), weight: await whole(one.weight, Int16Array) };
    })));
  }

  /** Shows a frame; later ones than the last of a thing are its last. */
  show(frame) {
    if (frame === this.shown) return;
    this.shown = frame;
    for (const one of this.things) {
      if (!this.dent(one, frame)) this.shown = -1; // its mesh is not there yet
    }
  }

  dent(one, frame) {
    const mesh = this.mesh(one);
    if (!mesh) return false;
    const position = mesh.geometry.getAttribute("position");
    if (one.geometry !== mesh.geometry) {
      one.geometry = mesh.geometry;
      one.rest ||= Float32Array.from(position.array);
    }
    const count = one.at.length;
    const depths = new Float32Array(count);
    const last = one.rows ? one.weight.length / one.rows - 1 : 0;
    for (let row = 0; row < one.rows; row++) {
      const weight = one.weight[Math.min(frame, last) * one.rows + row] * one.unit;
      if (weight === 0) continue;
      const start = row * count;
      for (let k = 0; k < count; k++) depths[k] += weight * one.depth[start + k];
    }
    for (let k = 0; k < count; k++) {
      const to = 3 * one.at[k];
      const depth = Math.max(depths[k], 0);
      for (let c = 0; c < 3; c++) position.array[to + c] = one.rest[to + c] + depth * one.way[3 * k + c];
    }
    position.needsUpdate = true;
    mesh.geometry.computeVertexNormals();
    redraw();
    return true;
  }

  mesh(one) {
    const parent = node(one.node);
    let found = null;
    if (parent) {
      parent.traverse((part) => {
        if (part.isMesh && part.geometry.getAttribute("position").count === one.count) found ||= part;
      });
    }
    return found;
  }
}
