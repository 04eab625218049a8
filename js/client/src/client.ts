// A client of a live session: connects, sends poses and edits, hears frames; comes back by itself.

import { decode, encode } from "@msgpack/msgpack";
import {
  JSON_PROTOCOL,
  MSGPACK_PROTOCOL,
  VERSION,
  type Action,
  type ErrorMessage,
  type FrameMessage,
  type FromClient,
  type FromServer,
  type Hello,
  type PersonPose,
  type SceneMessage,
  type Subscribe,
} from "./messages.js";

/** What of a WebSocket is used: a browser's, or that of the package `ws`. */
export interface Socket {
  binaryType: string;
  readonly readyState: number;
  readonly bufferedAmount: number;
  onopen: ((event: never) => unknown) | null;
  onmessage: ((event: never) => unknown) | null;
  onclose: ((event: never) => unknown) | null;
  onerror: ((event: never) => unknown) | null;
  send(data: string | Uint8Array<ArrayBuffer>): void;
  close(code?: number, reason?: string): void;
}
export type SocketClass = new (url: string, protocols: string[]) => Socket;

export interface Options {
  /** MessagePack (the default) or JSON. */
  binary?: boolean;
  /** What frames to hear; by default everything. */
  subscribe?: Omit<Subscribe, "type" | "id">;
  /** Name in the server's log. */
  name?: string;
  /** Come back after a lost connection; by default yes. */
  reconnect?: boolean;
  /** Longest time until an answer, and until the first connection [s]; by default 10. */
  patience?: number;
  /** The class of the socket; by default that of the browser. */
  WebSocket?: SocketClass;
}

/** The server refused a message, or could not be reached. */
export class LiveError extends Error {
  /** @param code Of the server's `ErrorMessage`, "closed" or "late". */
  constructor(
    readonly code: ErrorMessage["code"] | "closed" | "late",
    message: string,
  ) {
    super(message);
    this.name = "LiveError";
  }
}

/** Events and what their listeners are given. */
export interface Events {
  hello: Hello;
  scene: SceneMessage;
  frame: FrameMessage;
  /** An error that answers none of our edits, such as a pose for nobody. */
  error: LiveError;
  /** The connection is lost; `again`: seconds until the next try, null: there is none. */
  close: { reason: string; again: number | null };
}

/** What was heard, for a display. */
export interface Stats {
  /** Frames heard, and frames that the server made in between and did not send. */
  frames: number;
  dropped: number;
  /** Poses that were not sent, because the connection was behind. */
  unsent: number;
  /** Half of the shortest round trip of the last pings [s]; null: none yet. */
  latency: number | null;
  connections: number;
}

interface Waiting {
  resolve(answer: FromServer): void;
  reject(error: LiveError): void;
  timer: ReturnType<typeof setTimeout>;
}

const OPEN = 1;
/** A pose is not sent while so much waits to be sent: it would arrive late [bytes]. */
const BEHIND = 65_536;
/** First and longest pause before the next try [s]. */
const PAUSE = [0.25, 5] as const;
/** Round trips that the offset of the clocks is taken from. */
const PINGS = 8;

const now = (): number => performance.now() / 1000;

export class LiveClient {
  /** What the server said first, newest scene included; null: not connected yet. */
  hello: Hello | null = null;
  readonly stats: Stats = { frames: 0, dropped: 0, unsent: 0, latency: null, connections: 0 };

  private socket: Socket | null = null;
  private readonly listeners = new Map<keyof Events, Set<(what: never) => void>>();
  private readonly waiting = new Map<number, Waiting>();
  private readonly trips: { trip: number; offset: number }[] = [];
  private subscription: Omit<Subscribe, "type" | "id">;
  private lastFrame = -1;
  private count = 0;
  private tries = 0;
  private closed = false;
  private timer: ReturnType<typeof setTimeout> | null = null;

  private constructor(
    readonly url: string,
    private readonly options: Options,
  ) {
    this.subscription = options.subscribe ?? {};
  }

  /**
   * Connects to "ws://127.0.0.1:8765" and waits for the server's hello.
   *
   * Throws `LiveError` where there is no such server within `patience`, or it refuses.
   */
  static async connect(url: string, options: Options = {}): Promise<LiveClient> {
    const client = new LiveClient(url, options);
    await new Promise<void>((resolve, reject) => {
      const patience = options.patience ?? 10;
      const late = `no answer from ${url} within ${patience} s. Is "halfphysics serve" running there?`;
      const timer = setTimeout(() => fail(new LiveError("late", late)), 1000 * patience);
      const off = [
        client.on("hello", () => {
          finish();
          resolve();
        }),
        client.on("close", ({ reason }) => {
          if (options.reconnect === false || client.stats.connections === 0) {
            fail(new LiveError("closed", `${url}: ${reason}`));
          }
        }),
        client.on("error", fail),
      ];
      function finish(): void {
        clearTimeout(timer);
        for (const one of off) one();
      }
      function fail(error: LiveError): void {
        finish();
        client.close();
        reject(error);
      }
      client.open();
    });
    return client;
  }

  /** Calls `listener` at each event; returns what ends that. */
  on<E extends keyof Events>(event: E, listener: (what: Events[E]) => void): () => void {
    const all = this.listeners.get(event) ?? new Set();
    this.listeners.set(event, all);
    all.add(listener);
    return () => all.delete(listener);
  }

  /** Whether messages can be sent now. */
  get connected(): boolean {
    return this.socket?.readyState === OPEN && this.hello !== null;
  }

  /**
   * Sends poses of people, measured at `time` by our clock [s]; by default now.
   *
   * False: they were not sent, since there is no connection or it is behind. The next ones count.
   */
  sendPose(people: Record<string, PersonPose>, time: number = now()): boolean {
    if (!this.connected || this.socket!.bufferedAmount > BEHIND) {
      this.stats.unsent += 1;
      return false;
    }
    this.send({ type: "pose", people, time });
    return true;
  }

  /** Changes the scene before the next step; throws `LiveError` where the server refuses. */
  async edit(action: Action): Promise<void> {
    await this.ask((id) => ({ type: "edit", edit: action, id }));
  }

  /** Changes what frames to hear. */
  async subscribe(what: Omit<Subscribe, "type" | "id">): Promise<void> {
    await this.ask((id) => ({ type: "subscribe", ...what, id }));
    this.subscription = what;
    this.lastFrame = -1;
  }

  /** The time of a round trip [s]; keeps `stats.latency` and `serverTime` up to date. */
  async ping(): Promise<number> {
    const start = now();
    const answer = await this.ask((id) => ({ type: "ping", id, time: start }));
    const trip = now() - start;
    if (answer.type === "pong") {
      this.trips.push({ trip, offset: answer.clock - (start + trip / 2) });
      if (this.trips.length > PINGS) this.trips.shift();
      this.stats.latency = this.best()!.trip / 2;
    }
    return trip;
  }

  /** The server's clock now [s], by the shortest of the last round trips; null: no ping yet. */
  get serverTime(): number | null {
    const best = this.best();
    return best && now() + best.offset;
  }

  /** Ends the connection for good. */
  close(): void {
    this.closed = true;
    if (this.timer !== null) clearTimeout(this.timer);
    this.socket?.close(1000);
    this.abandon("the connection was closed here");
  }

  // -- inside ------------------------------------------------------------------------------------

  private best(): { trip: number; offset: number } | null {
    return this.trips.reduce<{ trip: number; offset: number } | null>(
      (a, b) => (a && a.trip <= b.trip ? a : b),
      null,
    );
  }

  private emit<E extends keyof Events>(event: E, what: Events[E]): void {
    for (const listener of [...(this.listeners.get(event) ?? [])]) listener(what as never);
  }

  private open(): void {
    const Class = this.options.WebSocket ?? (globalThis as { WebSocket?: SocketClass }).WebSocket;
    if (!Class) throw new TypeError('no WebSocket here: give options.WebSocket, such as that of "ws"');
    const protocol = this.options.binary === false ? JSON_PROTOCOL : MSGPACK_PROTOCOL;
    const socket = new Class(this.url, [protocol]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.send({ type: "hello", version: VERSION, name: this.options.name ?? "" });
      if (Object.keys(this.subscription).length) this.send({ type: "subscribe", ...this.subscription });
    };
    socket.onmessage = (event: { data: string | ArrayBuffer }) => this.heard(event.data);
    socket.onerror = () => undefined; // `onclose` follows
    socket.onclose = (event: { code: number; reason: string }) => this.lost(socket, event);
  }

  private send(message: FromClient): void {
    const binary = this.options.binary !== false;
    this.socket!.send(
      binary ? (encode(message, { ignoreUndefined: true }) as Uint8Array<ArrayBuffer>) : JSON.stringify(message),
    );
  }

  private ask(make: (id: number) => FromClient): Promise<FromServer> {
    if (!this.connected) return Promise.reject(new LiveError("closed", "there is no connection"));
    const id = ++this.count;
    return new Promise((resolve, reject) => {
      const patience = this.options.patience ?? 10;
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new LiveError("late", `no answer within ${patience} s`));
      }, 1000 * patience);
      this.waiting.set(id, { resolve, reject, timer });
      this.send(make(id));
    });
  }

  private heard(data: string | ArrayBuffer): void {
    const message = (typeof data === "string" ? JSON.parse(data) : decode(data)) as FromServer;
    switch (message.type) {
      case "hello":
        this.hello = message;
        this.stats.connections += 1;
        this.tries = 0;
        this.lastFrame = -1;
        this.emit("hello", message);
        break;
      case "scene":
        if (this.hello) this.hello = { ...this.hello, statics: message.statics, objects: message.objects };
        this.emit("scene", message);
        break;
      case "frame":
        this.counted(message);
        this.emit("frame", message);
        break;
      case "error":
        if (!this.answer(message)) this.emit("error", new LiveError(message.code, message.message));
        break;
      default:
        this.answer(message);
    }
  }

  private counted({ frame }: FrameMessage): void {
    const all = this.subscription.rate === undefined || this.subscription.rate === null;
    if (all && this.lastFrame >= 0) this.stats.dropped += Math.max(frame - this.lastFrame - 1, 0);
    this.lastFrame = frame;
    this.stats.frames += 1;
  }

  private answer(message: FromServer & { id?: unknown }): boolean {
    const waiting = typeof message.id === "number" ? this.waiting.get(message.id) : undefined;
    if (!waiting) return false;
    this.waiting.delete(message.id as number);
    clearTimeout(waiting.timer);
    if (message.type === "error") waiting.reject(new LiveError(message.code, message.message));
    else waiting.resolve(message);
    return true;
  }

  private lost(socket: Socket, event: { code: number; reason: string }): void {
    if (socket !== this.socket) return;
    const reason = event.reason || `the connection ended (code ${event.code})`;
    this.abandon(reason);
    this.trips.length = 0;
    const again = this.closed || this.options.reconnect === false ? null : this.pause();
    this.emit("close", { reason, again });
    if (again !== null && !this.closed) this.timer = setTimeout(() => this.open(), 1000 * again);
  }

  private pause(): number {
    return Math.min(PAUSE[0] * 2 ** this.tries++, PAUSE[1]);
  }

  private abandon(reason: string): void {
    for (const { reject, timer } of this.waiting.values()) {
      clearTimeout(timer);
      reject(new LiveError("closed", reason));
    }
    this.waiting.clear();
  }
}
