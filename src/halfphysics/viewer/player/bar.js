// The bar below the scene: play, step, the time line with its marks, speed.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const ICONS = {
  play: "M7 5v14l12-7z", pause: "M6 5h4v14H6zM14 5h4v14h-4z",
  back: "M18 5v14l-9-7zM6 5h2.5v14H6z", on: "M6 5v14l9-7zM15.5 5H18v14h-2.5z",
};

const icon = (name) => {
  const box = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  box.setAttribute("viewBox", "0 0 24 24");
  const path = document.createElementNS(box.namespaceURI, "path");
  path.setAttribute("d", ICONS[name]);
  box.append(path);
  return box;
};

class Bar {
  constructor(clock) {
    this.clock = clock;
    const button = (id, name, title, action) =>
      make("button", { id, title, "aria-label": title, onclick: action }, icon(name));
    this.play = button("hp-play", "play", "Play or pause (space)", () => clock.toggle());
    this.back = button("hp-back", "back", "One frame back (←)", () => clock.step(-1));
    this.on = button("hp-on", "on", "One frame on (→)", () => clock.step(1));
    this.text = make("output", { id: "hp-time" });
    this.head = make("div", { id: "hp-head" });
    this.rows = make("div", { id: "hp-rows" });
    this.tip = make("div", { id: "hp-tip", hidden: "" });
    this.track = make("div", { id: "hp-track", role: "slider", tabindex: "0",
      "aria-label": "Time", "aria-valuemin": "0" }, this.rows, this.head, this.tip);
    this.speed = make("select", { id: "hp-speed", title: "Speed", "aria-label": "Speed",
      onchange: () => {
        clock.setSpeed(Number(this.speed.value));
        this.speed.blur(); // the keys are the bar's again
      } },
      ...SPEEDS.map((speed) => make("option", { value: speed }, `${speed}×`)));
    this.speed.value = "1";
    this.extra = make("div", { id: "hp-extra" });
    this.help = make("button", { id: "hp-help-button", title: "Keys (?)", "aria-label": "Keys",
      onclick: () => help.toggle() }, "?");
    this.element = make("div", { id: "hp-bar" },
      make("div", { id: "hp-buttons" }, this.back, this.play, this.on), this.text, this.track,
      make("div", { id: "hp-right" }, this.speed, this.extra, this.help));
    this.listen();
  }

  listen() {
    const seek = (event) => {
      const box = this.track.getBoundingClientRect();
      this.clock.seek(((event.clientX - box.left) / box.width) * this.clock.duration);
    };
    this.track.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      this.track.setPointerCapture(event.pointerId);
      this.dragged = true;
      seek(event);
    });
    this.track.addEventListener("pointermove", (event) => {
      if (this.dragged) seek(event);
      this.hint(event);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      this.track.addEventListener(end, () => (this.dragged = false));
    }
    this.track.addEventListener("pointerleave", () => (this.tip.hidden = true));
  }

  /** What is at the pointer: the time, and the marks there of the row under it, or of all rows. */
  hint(event) {
    const box = this.track.getBoundingClientRect();
    const time = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * this.clock.duration;
    const near = (4 / box.width) * this.clock.duration;
    const under = this.marks.filter((row, k) => {
      const place = this.rows.children[k].getBoundingClientRect();
      return event.clientY >= place.top - 1 && event.clientY <= place.bottom + 1;
    });
    const lines = [`${time.toFixed(2)} s`];
    for (const row of under.length ? under : this.marks) {
      for (const [start, end, text] of row.marks) {
        if (start - near <= time && time <= end + near) lines.push(`${row.label}: ${text}`);
      }
    }
    this.tip.textContent = lines.slice(0, 7).join("\n");
    this.tip.hidden = false;
    const left = Math.min(Math.max(event.clientX - box.left, 90), Math.max(box.width - 90, 90));
    this.tip.style.left = `${left}px`;
  }

  /** Shows rows of marks: [{label, color, marks: [[start, end, text], ...]}, ...]. */
  setMarks(rows) {
    const state = `${JSON.stringify(rows)}${this.clock.duration}`;
    if (state === this.marked) return;
    this.marked = state;
    this.marks = rows;
    const share = (time) => `${(100 * time) / Math.max(this.clock.duration, 1e-9)}%`;
    this.rows.replaceChildren(...rows.map((row) =>
      make("div", { class: "hp-row", "aria-label": row.label }, ...row.marks.map(([start, end, text]) => {
        const mark = make("i", { class: "hp-mark", "data-text": text });
        Object.assign(mark.style, { left: share(start), width: share(end - start),
          background: row.color });
        return mark;
      }))));
    this.element.style.setProperty("--rows", rows.length);
    document.documentElement.style.setProperty("--hp-rows", rows.length);
  }

  refresh() {
    const { clock } = this;
    const time = clock.shown;
    const state = `${time}|${clock.duration}|${clock.playing}|${clock.speed}|${clock.live}`;
    if (state === this.state) return;
    this.state = state;
    this.head.style.left = `${(100 * time) / Math.max(clock.duration, 1e-9)}%`;
    const text = `${time.toFixed(2)} / ${clock.duration.toFixed(2)} s`;
    this.text.replaceChildren(make("b", {}, time.toFixed(2)), text.slice(time.toFixed(2).length));
    this.track.setAttribute("aria-valuemax", clock.duration.toFixed(3));
    this.track.setAttribute("aria-valuenow", time.toFixed(3));
    if (this.playing !== clock.playing) {
      this.playing = clock.playing;
      this.play.replaceChildren(icon(clock.playing ? "pause" : "play"));
    }
    if (document.activeElement !== this.speed) {
      const near = SPEEDS.reduce((a, b) =>
        Math.abs(b - clock.speed) < Math.abs(a - clock.speed) ? b : a);
      this.speed.value = `${near}`;
    }
    this.back.disabled = clock.live;
  }
}
