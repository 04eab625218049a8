// The messages of a live session, version 1: src/halfphysics/live/schema.py, docs/live.md.
//
// World: right-handed, z up; metres, seconds, kilograms, newtons; rotations axis-angle [rad];
// quaternions w, x, y, z.

/** Version of the messages. */
export const VERSION = 1;

/** Subprotocol of a WebSocket: how the server writes what it sends. */
export const JSON_PROTOCOL = `halfphysics.v${VERSION}.json`;
export const MSGPACK_PROTOCOL = `halfphysics.v${VERSION}.msgpack`;

export type Point = [number, number, number];
/** Axis times angle [rad]. */
export type Rotation = [number, number, number];
/** w, x, y, z. */
export type Quaternion = [number, number, number, number];
export type Id = number | string | null;

/** Parts of a frame that a client can subscribe to. */
export type Part = "poses" | "targets" | "objects" | "joints" | "contacts" | "pressures";

// -- from the client ---------------------------------------------------------------------------

export interface PersonPose {
  /** Root translation, as SMPL-X has it [m]. */
  translation: Point;
  /** Rotations of the 55 joints relative to their parents. */
  rotations: Rotation[];
  /** Joints that are measured (55); the others are held, then relax. Missing or null: all. */
  tracked?: boolean[] | null;
}

/** Poses of people who were measured at one moment: they are stepped together. */
export interface PoseMessage {
  type: "pose";
  people: Record<string, PersonPose>;
  /** The client's clock when the poses were measured [s]. */
  time?: number | null;
}

/** An object of a simple shape: "sphere:0.11", "box:0.4:0.3:0.2", "capsule:0.1:0.5". */
export interface Add {
  action: "add";
  name: string;
  shape: string;
  mass: number;
  position: Point;
  quaternion?: Quaternion;
  velocity?: Point;
  friction?: number | null;
  restitution?: number | null;
}

export interface Remove {
  action: "remove";
  name: string;
}

/** The first drag takes hold at `grip` (or at the pointer), the next ones move the pointer; null lets go. */
export interface Drag {
  action: "drag";
  name: string;
  pointer: Point | null;
  grip?: Point | null;
}

export interface Mass {
  action: "mass";
  name: string;
  value: number;
}

export interface Friction {
  action: "friction";
  name: string;
  value: number;
}

/** Stiffness of a person's joints (null: everybody's), one number or by joint group. */
export interface Stiffness {
  action: "stiffness";
  value: number | Record<string, number>;
  person?: string | null;
}

/** Push an object [N s], at a point or at its centre of mass. */
export interface Impulse {
  action: "impulse";
  name: string;
  impulse: Point;
  point?: Point | null;
}

export type Action = Add | Remove | Drag | Mass | Friction | Stiffness | Impulse;

/** A change of the scene, before the next step. Answered by `Done` or `ErrorMessage`. */
export interface Edit {
  type: "edit";
  edit: Action;
  id?: Id;
}

/** Which parts of frames to send (missing: all but pressures), of which people, and how often [1/s]. */
export interface Subscribe {
  type: "subscribe";
  parts?: Part[];
  people?: string[] | null;
  rate?: number | null;
  id?: Id;
}

/** Answered at once, with the server's clock. */
export interface Ping {
  type: "ping";
  id?: Id;
  time?: number | null;
}

/** May come first: the version that the client speaks, and its name for the server's log. */
export interface ClientHello {
  type: "hello";
  version: number;
  name?: string;
}

export type FromClient = ClientHello | PoseMessage | Edit | Subscribe | Ping;

// -- from the server ---------------------------------------------------------------------------

/** A person; `joints` are rest positions of the 55 joints in the body's own axes (y up) [m]. */
export interface PersonItem {
  name: string;
  stature: number;
  mass: number;
  joints: Point[];
}

/** A static or an object; `mass` missing or 0: it does not move, or on a trajectory. */
export interface SceneItem {
  name: string;
  shape: { kind: string; [key: string]: unknown };
  position: Point;
  quaternion: Quaternion;
  friction: number;
  mass?: number;
  /** Fields of a soft layer: thickness [m], stiffness [Pa/m], ...; missing or null: it is hard. */
  soft?: { thickness: number; stiffness: number; [key: string]: unknown } | null;
}

/** The first message of the server. */
export interface Hello {
  type: "hello";
  version: number;
  server: string;
  fps: number;
  people: PersonItem[];
  statics: SceneItem[];
  objects: SceneItem[];
  /** Names of the 55 joints. */
  joints: string[];
  /** Parent of each joint; -1: none. */
  parents: number[];
  units: Record<string, string>;
  axes: string;
  /** The server's clock [s]. */
  clock: number;
  limits: Record<string, number>;
}

/** What is in the scene now; sent to everybody after an edit that changed it. */
export interface SceneMessage {
  type: "scene";
  statics: SceneItem[];
  objects: SceneItem[];
}

/** The way of the newest pose: the sender's clock, then the server's [s]. */
export interface StampItem {
  sent: number | null;
  received: number;
  stepped: number;
}

/** A person in a frame. Fields of parts that are not subscribed to are missing. */
export interface PersonFrame {
  tracking: string;
  stamp?: StampItem | null;
  translation?: Point;
  rotations?: Rotation[];
  target_translation?: Point;
  target_rotations?: Rotation[];
}

export interface Place {
  position: Point;
  quaternion: Quaternion;
}

/** A pair that touched during the frame; `force` [N] acts on the subject. Of two people each has a row. */
export interface Contact {
  subject: string;
  part: string | null;
  other: string;
  other_part: string | null;
  position: Point;
  normal: Point;
  force: Point;
}

/** Samples of `other` that press `layer`, which gives way: [m], [Pa], [m2]; normals point out of the layer. */
export interface Pressed {
  layer: string;
  other: string;
  position: Point[];
  normal: Point[];
  depth: number[];
  pressure: number[];
  area: number[];
}

/** One frame of the simulation. */
export interface FrameMessage {
  type: "frame";
  frame: number;
  time: number;
  clock: number;
  clearance: number | null;
  people: Record<string, PersonFrame>;
  objects?: Record<string, Place>;
  joints?: Record<string, number | number[]>;
  contacts?: Contact[];
  pressures?: Pressed[];
}

/** An edit or a subscription was carried out. */
export interface Done {
  type: "done";
  id: Id;
}

/** A message was refused; `message` says what was found, what was expected, the way out. */
export interface ErrorMessage {
  type: "error";
  code: "invalid" | "refused" | "version" | "busy";
  message: string;
  id?: Id;
}

/** Answer to `Ping`. */
export interface Pong {
  type: "pong";
  id: Id;
  time: number | null;
  clock: number;
}

export type FromServer = Hello | SceneMessage | FrameMessage | Done | ErrorMessage | Pong;
