// What one can turn in a page with physics: stiffness of the person, mass and friction of an object.

/** A slider with its label and value. `scale` "log": equal ways are equal factors. */
class Slider {
  constructor(label, { low, high, scale, digits = 2, unit: suffix = "" }, change) {
    this.log = scale === "log";
    Object.assign(this, { digits, suffix });
    const ends = this.log ? [Math.log(low), Math.log(high)] : [low, high];
    this.input = make("input", { type: "range", min: ends[0], max: ends[1], step: "any",
      "aria-label": label, oninput: () => {
        this.write();
        change(this.value);
      } });
    this.text = make("output");
    this.element = make("label", { class: "hp-knob" }, make("span", {}, label), this.input, this.text);
  }

  get value() {
    const value = Number(this.input.value);
    return Number((this.log ? Math.exp(value) : value).toPrecision(3));
  }

  set value(value) {
    this.input.value = this.log ? Math.log(value) : value;
    this.write(value);
  }

  write(value = this.value) {
    const digits = value >= 100 ? 0 : value >= 10 ? 1 : this.digits;
    const shown = this.log && value < 0.1 ? value.toPrecision(2) : value.toFixed(digits);
    this.text.textContent = `${shown}${this.suffix}`;
  }
}

class Knobs {
  constructor(physics) {
    this.physics = physics;
    const { play } = physics;
    this.stiffness = new Slider("Stiffness λ", { low: 0, high: 10 }, (value) => physics.turn("stiffness", value));
    const masses = play.objects.map((one) => one.mass || 0).filter((mass) => mass > 0);
    const [light, heavy] = [Math.min(0.01, ...masses), Math.max(0, ...masses)];
    this.mass = new Slider("Mass", { low: light, high: Math.max(200, 20 * heavy), scale: "log", unit: " kg" },
      (value) => physics.turn("mass", value, this.object));
    this.friction = new Slider("Friction μ", { low: 0, high: 2 },
      (value) => physics.turn("friction", value, this.object));
    const movable = play.objects.filter((one) => one.free);
    this.object = movable[0];
    this.which = make("select", { "aria-label": "Object", onchange: () => {
      this.object = movable.find((one) => one.name === this.which.value);
      this.refresh();
    } }, ...movable.map((one) => make("option", { value: one.name }, one.name)));
    this.loop = make("input", { type: "checkbox", onchange: () => (physics.loop = this.loop.checked) });
    this.hold = make("input", { type: "checkbox", onchange: () => (physics.hold = this.hold.checked) });
    this.loop.checked = physics.loop;
    this.status = make("div", { id: "hp-pace" });
    const things = movable.length ? [make("div", { class: "hp-which" },
      movable.length > 1 ? this.which : make("b", {}, movable[0].name),
      make("small", {}, "drag it with the pointer")), this.mass.element, this.friction.element] : [];
    this.element = make("div", { id: "hp-knobs" }, this.status,
      ...(play.people.length ? [this.stiffness.element] : []), ...things,
      make("div", { class: "hp-layers" }, make("label", {}, this.loop, "Loop"),
        make("label", { title: "The motion stands still, physics goes on" }, this.hold, "Hold the pose")),
      make("div", { class: "hp-cameras" }, make("button", { onclick: () => physics.restart() }, "Start again"),
        make("button", { onclick: () => { physics.own(); this.refresh(); } }, "As it was")));
    this.refresh();
  }

  refresh() {
    const { physics, object } = this;
    const { stiffness } = physics.turned;
    this.stiffness.value = stiffness === null ? physics.play.stiffnessShown : stiffness;
    if (!object) return;
    this.mass.value = physics.turned.mass[object.name];
    this.friction.value = physics.turned.friction[object.name];
  }
}
