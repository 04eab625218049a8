// A camera that circles a point: projects points of the world (z up) and casts rays back.

import type { Point } from "../src/index.js";

export type Pixel = { x: number; y: number; depth: number };

const FOV = 0.6; // vertical angle [rad]

export const add = (a: Point, b: Point, s = 1): Point => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Point, b: Point): Point => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export class Camera {
  target: Point = [0, 0, 0.9];
  angle = 0.9;
  height = 0.25;
  distance = 5.5;
  /** The target goes along with the people. */
  following = true;
  width = 1;
  pixels = 1;

  /** Ahead, right and up. */
  private axes(): [Point, Point, Point] {
    const level = Math.cos(this.height);
    const ahead: Point = [
      -level * Math.cos(this.angle),
      -level * Math.sin(this.angle),
      -Math.sin(this.height),
    ];
    const right: Point = [-Math.sin(this.angle), Math.cos(this.angle), 0];
    return [ahead, right, cross(right, ahead)];
  }

  get position(): Point {
    return add(this.target, this.axes()[0], -this.distance);
  }

  /** Pixels of a metre at a depth of one metre. */
  private get focal(): number {
    return this.pixels / (2 * Math.tan(FOV / 2));
  }

  /** Where a point is on the screen; null: it is not in front of the camera. */
  project(point: Point): Pixel | null {
    const [ahead, right, up] = this.axes();
    const from = add(point, this.position, -1);
    const depth = dot(from, ahead);
    if (depth < 0.05) return null;
    const scale = this.focal / depth;
    return {
      x: this.width / 2 + dot(from, right) * scale,
      y: this.pixels / 2 - dot(from, up) * scale,
      depth,
    };
  }

  /** Pixels of a length at a depth [m]. */
  size(length: number, depth: number): number {
    return (length * this.focal) / depth;
  }

  /** The point under a pixel, at the depth of another point. */
  unproject(x: number, y: number, depth: number): Point {
    const [ahead, right, up] = this.axes();
    const s = depth / this.focal;
    const aside = add([0, 0, 0], right, (x - this.width / 2) * s);
    return add(add(add(this.position, ahead, depth), aside), up, (this.pixels / 2 - y) * s);
  }

  turn(dx: number, dy: number): void {
    this.angle -= dx * 0.008;
    this.height = Math.min(Math.max(this.height + dy * 0.006, -0.2), 1.5);
  }
}
