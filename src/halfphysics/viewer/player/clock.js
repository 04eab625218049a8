// The time that is shown. The page has its own clock; `view` and `play` have theirs on the server,
// which says what it does a few times a second.

class OwnClock {
  constructor(duration, fps) {
    Object.assign(this, { duration, fps, time: 0, playing: false, speed: 1, loop: true, live: false });
    this.last = performance.now();
  }

  tick() {
    const now = performance.now();
    // A page that was in the background goes on where it was.
    const passed = Math.min((now - this.last) / 1000, 0.25) * this.speed;
    this.last = now;
    if (!this.playing) return;
    this.time += passed;
    const end = this.duration + 1 / this.fps;
    if (this.time < (this.loop ? end : this.duration)) return;
    if (this.loop) this.time %= end;
    else [this.time, this.playing] = [this.duration, false];
  }

  get shown() {
    return Math.min(this.time, this.duration);
  }

  toggle() {
    if (!this.playing && !this.loop && this.time >= this.duration) this.time = 0;
    this.playing = !this.playing;
  }

  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
  }

  step(frames) {
    this.playing = false;
    const last = Math.round(this.duration * this.fps);
    const frame = Math.floor(this.shown * this.fps + 1e-6) + frames;
    this.seek((((frame % (last + 1)) + last + 1) % (last + 1)) / this.fps);
  }

  setSpeed(speed) {
    this.speed = speed;
  }
}

class ServerClock {
  constructor() {
    Object.assign(this, { duration: 0, fps: 30, time: 0, playing: false, speed: 1, loop: true,
      live: false, heard: 0 });
  }

  /** What the server says: any of the attributes. */
  hear(state) {
    Object.assign(this, state);
    this.heard = performance.now();
  }

  tick() {}

  get shown() {
    if (this.live || !this.playing) return this.time;
    const passed = Math.min((performance.now() - this.heard) / 1000, 1) * this.speed;
    return Math.min(this.time + passed, this.duration);
  }

  toggle() { command({ do: "toggle" }); }
  step(frames) { command({ do: "step", to: frames }); }
  setSpeed(speed) { command({ do: "speed", to: speed }); }

  seek(time) {
    if (!this.live) this.hear({ time: Math.min(Math.max(time, 0), this.duration) });
    command({ do: "seek", to: time });
  }
}
