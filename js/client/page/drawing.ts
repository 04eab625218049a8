// Draws a frame of a live session on a canvas: floor, scene, people as limbs, contacts.

import {
  jointPositions,
  turned,
  type FrameMessage,
  type Hello,
  type Point,
  type Quaternion,
  type SceneItem,
} from "../src/index.js";
import { add, type Camera } from "./camera.js";

const PEOPLE = ["#1f756e", "#a34a3c", "#5b4b8a", "#8a6d1f"];
const OBJECT = "#f08c38";
const GHOST = "#4082f0";
const FORCE = "#0d7a38";
/** Thickness of limbs by the joint at their end [m]; fingers are thin. */
const thickness = (name: string): number =>
  /index|middle|ring|pinky|thumb|eye|jaw/.test(name) ? 0.02
  : /spine|collar|neck/.test(name) ? 0.2
  : /hip|knee/.test(name) ? 0.13
  : /head/.test(name) ? 0.17 : 0.075;
/** Length of an arrow [m]: as in the viewer, 6 cm up to 1 N, 8 cm more for ten times the force. */
const arrowLength = (force: number): number => 0.06 + 0.08 * Math.log10(Math.min(Math.max(force, 1), 1e4));

export class Drawing {
  private readonly pen: CanvasRenderingContext2D;
  private dark = matchMedia("(prefers-color-scheme: dark)").matches;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly camera: Camera,
  ) {
    this.pen = canvas.getContext("2d")!;
  }

  fit(): void {
    const scale = devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    if (this.canvas.width !== clientWidth * scale) this.canvas.width = clientWidth * scale;
    if (this.canvas.height !== clientHeight * scale) this.canvas.height = clientHeight * scale;
    this.pen.setTransform(scale, 0, 0, scale, 0, 0);
    [this.camera.width, this.camera.pixels] = [clientWidth, clientHeight];
  }

  show(hello: Hello, frame: FrameMessage | null): void {
    this.fit();
    this.pen.clearRect(0, 0, this.camera.width, this.camera.pixels);
    this.floor();
    for (const item of hello.statics) this.item(item, item, this.dark ? "#7d8794" : "#9aa3af");
    for (const item of hello.objects) this.item(item, frame?.objects?.[item.name] ?? item, OBJECT);
    if (!frame) return;
    hello.people.forEach((person, k) => {
      const now = frame.people[person.name];
      if (!now) return;
      if (now.target_translation && now.target_rotations) {
        const places = jointPositions(hello, person, now.target_translation, now.target_rotations);
        this.limbs(hello, places, GHOST, 0.3);
      }
      if (now.translation && now.rotations) {
        const places = jointPositions(hello, person, now.translation, now.rotations);
        this.limbs(hello, places, PEOPLE[k % PEOPLE.length]!, 1);
      }
    });
    for (const { position, force } of frame.contacts ?? []) {
      const size = Math.hypot(...force);
      if (size > 0) this.line(position, add(position, force, arrowLength(size) / size), FORCE, 0.012);
    }
  }

  private line(a: Point, b: Point, color: string, width: number, alpha = 1): void {
    const [p, q] = [this.camera.project(a), this.camera.project(b)];
    if (!p || !q) return;
    const { pen } = this;
    pen.globalAlpha = alpha;
    pen.strokeStyle = color;
    pen.lineCap = "round";
    pen.lineWidth = Math.max(this.camera.size(width, (p.depth + q.depth) / 2), 1);
    pen.beginPath();
    pen.moveTo(p.x, p.y);
    pen.lineTo(q.x, q.y);
    pen.stroke();
    pen.globalAlpha = 1;
  }

  private floor(): void {
    const color = this.dark ? "#454c56" : "#d5d9df";
    const [x, y] = [Math.round(this.camera.target[0]), Math.round(this.camera.target[1])];
    for (let k = -6; k <= 6; k++) {
      for (let m = -6; m < 6; m++) {
        this.line([x + k, y + m, 0], [x + k, y + m + 1, 0], color, 0);
        this.line([x + m, y + k, 0], [x + m + 1, y + k, 0], color, 0);
      }
    }
  }

  private limbs(hello: Hello, places: Point[], color: string, alpha: number): void {
    const limbs = hello.parents
      .map((parent, j) => ({ parent, j, depth: this.camera.project(places[j]!)?.depth ?? 0 }))
      .filter(({ parent }) => parent >= 0)
      .sort((a, b) => b.depth - a.depth);
    for (const { parent, j } of limbs) {
      this.line(places[parent]!, places[j]!, color, thickness(hello.joints[j]!) * (alpha < 1 ? 0.4 : 1), alpha);
    }
  }

  private item(item: SceneItem, place: { position: Point; quaternion: Quaternion }, color: string): void {
    const { shape } = item;
    const world = (p: Point): Point => add(place.position, turned(place.quaternion, p));
    if (shape.kind === "sphere" || shape.kind === "capsule" || shape.kind === "cylinder") {
      const half = shape.kind === "sphere" ? 0 : Number(shape["length"]) / 2;
      this.line(world([0, 0, -half]), world([0, 0, half]), color, 2 * Number(shape["radius"]), 0.85);
    } else if (shape.kind === "box" || shape.kind === "bounds") {
      const size = shape["size"] as Point | undefined;
      const low = size ? (size.map((x) => -x / 2) as Point) : (shape["low"] as Point);
      const high = size ? (size.map((x) => x / 2) as Point) : (shape["high"] as Point);
      this.box(low, high, world, color);
    } else if (shape.kind === "mesh") {
      this.mesh(shape["vertices"] as Point[], shape["faces"] as Point[], world, color);
    }
  }

  private box(low: Point, high: Point, world: (p: Point) => Point, color: string): void {
    const corner = (k: number): Point =>
      [0, 1, 2].map((axis) => ((k >> axis) & 1 ? high : low)[axis]) as Point;
    for (let k = 0; k < 8; k++) {
      for (const bit of [1, 2, 4]) {
        if (!(k & bit)) this.line(world(corner(k)), world(corner(k | bit)), color, 0.012);
      }
    }
  }

  private mesh(vertices: Point[], faces: Point[], world: (p: Point) => Point, color: string): void {
    const places = vertices.map(world);
    for (const [a, b, c] of faces) {
      this.line(places[a]!, places[b]!, color, 0.004, 0.6);
      this.line(places[b]!, places[c]!, color, 0.004, 0.6);
    }
  }
}
