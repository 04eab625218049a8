// World positions of a person's joints, by forward kinematics.

import type { Hello, PersonItem, Point, Quaternion, Rotation } from "./messages.js";

/** The product of two quaternions: the rotation `b`, then `a`. */
export function times(a: Quaternion, b: Quaternion): Quaternion {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

/** A vector, turned by a quaternion. */
export function turned([w, x, y, z]: Quaternion, [a, b, c]: Point): Point {
  const t = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)] as const;
  return [
    a + w * t[0] + y * t[2] - z * t[1],
    b + w * t[1] + z * t[0] - x * t[2],
    c + w * t[2] + x * t[1] - y * t[0],
  ];
}

/** The quaternion of axis times angle [rad]. */
export function quaternion([x, y, z]: Rotation): Quaternion {
  const angle = Math.hypot(x, y, z);
  const s = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), x * s, y * s, z * s];
}

/**
 * World positions of the 55 joints [m] of a pose.
 *
 * SMPL-X: the pelvis is at its rest position plus the translation, whatever its rotation.
 */
export function jointPositions(
  hello: Pick<Hello, "parents">,
  person: Pick<PersonItem, "joints">,
  translation: Point,
  rotations: Rotation[],
): Point[] {
  const places: Point[] = [];
  const turns: Quaternion[] = [];
  hello.parents.forEach((parent, j) => {
    const own = quaternion(rotations[j]!);
    const rest = person.joints[j]!;
    if (parent < 0) {
      turns.push(own);
      places.push([rest[0] + translation[0], rest[1] + translation[1], rest[2] + translation[2]]);
      return;
    }
    const [from, place, turn] = [person.joints[parent]!, places[parent]!, turns[parent]!];
    const arm = turned(turn, [rest[0] - from[0], rest[1] - from[1], rest[2] - from[2]]);
    turns.push(times(turn, own));
    places.push([place[0] + arm[0], place[1] + arm[1], place[2] + arm[2]]);
  });
  return places;
}
