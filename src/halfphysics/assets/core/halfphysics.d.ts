// Types of halfphysics.js: the native core in browsers and node (docs/c-api.md). Metres, kilograms, seconds; the world is
// z-up; quaternions are w, x, y, z; rotations are axis-angle vectors [rad] of the 55 joints of SMPL-X.

export type Vector = ArrayLike<number>;

export interface Pose {
  /** Of the pelvis, as SMPL-X has it (3) [m]. */
  translation: Vector;
  /** Of the joints, relative to their parents, the pelvis first (55 x 3) [rad]. */
  rotations: Vector;
}

export interface CorrectedPose extends Pose {
  translation: Float64Array;
  rotations: Float64Array;
}

/** One contact during the last frame. Where two people touch, each has one of its own. */
export interface Contact {
  /** Index of the person, -1 where an object touches something that is no person. */
  person: number;
  /** Joint index of the person's part, -1 for objects. */
  part: number;
  /** Index into `names` of the object that plays the part's role, else -1. */
  subject: number;
  /** Index into `names` of what was touched. */
  other: number;
  /** Joint index on the other, where that is a person, else -1. */
  otherPart: number;
  /** In the world [m]. */
  position: number[];
  /** Unit vector from the other into the part. */
  normal: number[];
  /** On the part, summed over the frame [N s]. */
  impulse: number[];
  /** The same as a mean over the frame [N]. */
  force: number[];
}

/** A call of the core that failed; `status` is its hp_status of halfphysics.h. */
export class HalfPhysicsError extends Error {
  status: number;
}

export class HalfPhysics {
  /** From the bytes of halfphysics.wasm, its address, a Response or a compiled module. */
  static load(
    source: BufferSource | string | URL | Response | WebAssembly.Module,
  ): Promise<HalfPhysics>;
  /** As of the Python package. */
  readonly version: string;
  /** The layout of world files that is read. */
  readonly worldFileVersion: number;
  /** "pelvis", "left_hip", ... (55). */
  readonly jointNames: readonly string[];
  /** A world from the bytes of a world file. Throws HalfPhysicsError. */
  world(bytes: ArrayBuffer | Uint8Array): World;
}

/** People and a scene that are simulated; `HalfPhysics.world` makes one. Methods throw HalfPhysicsError. */
export class World {
  private constructor();
  /** Number of people. */
  readonly people: number;
  /** All that contacts refer to: statics, objects, links, people. */
  readonly names: readonly string[];
  /** What each of `names` is. */
  readonly kinds: readonly ("static" | "object" | "link" | "person")[];
  /** What moves: the 55 parts of each person ("person/left_hip"), then objects, then links. */
  readonly bodyNames: readonly string[];
  /** Joints of articulated objects ("door/hinge"). */
  readonly jointNames: readonly string[];

  /** Puts the people at a pose and objects at their start; everything else is forgotten. */
  reset(pose: Pose | readonly Pose[]): void;
  /** Drives the people towards a pose for one frame of `dt` seconds. */
  step(pose: Pose | readonly Pose[], dt: number): void;

  /** The corrected pose of a person. */
  pose(person?: number): CorrectedPose;
  /** Position and quaternion of every body: 7 numbers each, in the order of `bodyNames`. */
  bodies(out?: Float64Array): Float64Array;
  /** Position and quaternion of an object or a link. */
  object(name: string): { position: Float64Array; quaternion: Float64Array };
  /** Velocity of an object's origin [m/s] and angular velocity [rad/s], in the world. */
  velocity(name: string): { velocity: Float64Array; angularVelocity: Float64Array };
  /** Value of a joint of an articulated object: 1 number [rad or m], 4 of a ball, 7 of a free joint. */
  joint(name: string): Float64Array;
  /** Contacts of the last frame. */
  contacts(): Contact[];
  /** Minimum distance of the people from static geometry [m]; Infinity beyond what the settings ask for. */
  clearance(): number;
  /** Time by which blocked steps of the last frame were shortened [s]. */
  lostTime(): number;

  /** Stiffness of the joints, a number or 55 of them; person -1: of all. `reset` goes back. */
  setStiffness(stiffness: number | Vector, person?: number): void;
  /** Mass of a free object [kg]; its inertia changes by the same factor. */
  setMass(name: string, kg: number): void;
  mass(name: string): number;
  /** Friction of an item or a person with all others, but for pairs that the scene has set apart. */
  setFriction(name: string, friction: number): void;
  setVelocity(name: string, velocity: Vector, angularVelocity?: Vector | null): void;
  /** An impulse (3) [N s] at a point (3) of the world [m], or at the centre of mass. */
  applyImpulse(name: string, impulse: Vector, point?: Vector | null): void;
  /** The axes (3 x 3, by rows) in which a person's poses are given; see hp_set_axes of halfphysics.h. */
  setAxes(axes: Vector, person?: number): void;

  /** Everything that the simulation remembers, to go on from later, bit for bit. */
  save(): Uint8Array;
  /** Goes on from a state of a world of the same file. */
  load(state: Uint8Array): void;
  /** Gives the memory back; the world cannot be used any longer. */
  free(): void;
}
