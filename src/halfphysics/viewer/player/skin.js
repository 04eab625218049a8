// The skin, coloured by contact force at every vertex, on a logarithmic scale from 1 N to 1 kN.
//
// A contact is given in the rest pose of the body (viewer/skin_forces.py). There hands are away from
// the trunk and legs from each other, so that the distance to a vertex is nearly that on the skin. The
// force at a vertex is the sum of the contacts' forces, each by exp(-(distance / WIDTH)²).

const WIDTH = 0.04; // [m]
const DECADES = 3; // from 1 N
const SOFT = 0.12; // share of the scale over which the colour comes in

class SkinForces {
  /** @param ramp Colours from 1 N to 1 kN, each three numbers from 0 to 1 (sRGB). */
  constructor(ramp) {
    this.ramp = ramp.map((color) => color.map(linear));
    this.on = true;
    this.painted = new Set();
  }

  /** Colours a person: `points` are [x, y, z, force [N]] in the rest pose. */
  show(name, points) {
    const object = node(name);
    if (!object) return;
    object.traverse((part) => {
      if (part.isSkinnedMesh && part.material && part.material.color) {
        this.paint(part, this.on ? points : []);
      }
    });
  }

  paint(mesh, points) {
    const { geometry, material } = mesh;
    let colors = geometry.getAttribute("color");
    if (!colors) {
      if (!points.length) return;
      const Attribute = geometry.getAttribute("position").constructor;
      colors = new Attribute(new Float32Array(geometry.getAttribute("position").count * 3).fill(1), 3);
      geometry.setAttribute("color", colors);
    }
    if (!material.vertexColors) {
      material.vertexColors = true;
      material.needsUpdate = true;
    }
    if (!points.length && !this.painted.has(mesh)) return;
    const base = [material.color.r, material.color.g, material.color.b];
    const forces = this.forces(geometry.getAttribute("position").array, points);
    for (let k = 0; k < forces.length; k++) {
      const level = Math.min(Math.log10(Math.max(forces[k], 1)) / DECADES, 1);
      const share = Math.min(level / SOFT, 1);
      for (let c = 0; c < 3; c++) {
        const wanted = this.color(level, c) / Math.max(base[c], 1e-3);
        colors.array[3 * k + c] = 1 + share * (wanted - 1);
      }
    }
    colors.needsUpdate = true;
    if (points.length) this.painted.add(mesh);
    else this.painted.delete(mesh);
    redraw();
  }

  forces(vertices, points) {
    const forces = new Float32Array(vertices.length / 3);
    for (const [x, y, z, force] of points) {
      // Beyond this distance less than 1 N is left.
      const far = WIDTH ** 2 * Math.log(Math.max(force, 1));
      for (let k = 0, at = 0; k < forces.length; k++, at += 3) {
        const square = (vertices[at] - x) ** 2 + (vertices[at + 1] - y) ** 2 + (vertices[at + 2] - z) ** 2;
        if (square < far) forces[k] += force * Math.exp(-square / WIDTH ** 2);
      }
    }
    return forces;
  }

  color(level, channel) {
    const place = level * (this.ramp.length - 1);
    const k = Math.min(Math.floor(place), this.ramp.length - 2);
    return this.ramp[k][channel] + (place - k) * (this.ramp[k + 1][channel] - this.ramp[k][channel]);
  }
}

const linear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
