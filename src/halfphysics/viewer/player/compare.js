// A and B with a slider: the scene is drawn twice, left of a line with one set of nodes, right of it
// with the other. A comparison is {a, b}, each with a `label`, nodes to `hide` and to `show`, and
// `move`: node -> its place [m], to put results that stand side by side into one place.

class Compare {
  constructor() {
    this.choices = [];
    this.index = -1;
    this.share = 0.5;
    this.button = make("button", { id: "hp-compare", title: "Compare (c)", "aria-label": "Compare",
      onclick: () => this.next() }, "A|B");
    this.line = make("div", { id: "hp-line", hidden: "", role: "separator",
      "aria-label": "Drag to compare" }, make("span"), make("b"), make("span"));
    this.line.addEventListener("pointerdown", (event) => {
      this.line.setPointerCapture(event.pointerId);
      this.dragged = true;
      event.stopPropagation();
    });
    this.line.addEventListener("pointermove", (event) => {
      if (!this.dragged) return;
      const box = viser.canvas.getBoundingClientRect();
      this.share = Math.min(Math.max((event.clientX - box.left) / box.width, 0.02), 0.98);
      this.place();
    });
    for (const end of ["pointerup", "pointercancel"]) {
      this.line.addEventListener(end, () => (this.dragged = false));
    }
    document.body.append(this.line);
    addEventListener("resize", () => this.place());
    whenReady(() => this.hook());
  }

  get on() { return this.choices[this.index]; }

  setChoices(choices) {
    this.choices = choices;
    this.button.hidden = !choices.length;
    if (this.index >= choices.length) this.choose(-1);
    else if (this.on) this.place();
  }

  next() {
    if (!this.choices.length) return say("There is nothing to compare: this is one motion.");
    this.choose(this.index + 1 >= this.choices.length ? -1 : this.index + 1);
  }

  choose(index) {
    this.index = index;
    command({ do: "compare", to: Boolean(this.on) });
    this.line.hidden = !this.on;
    this.button.classList.toggle("hp-on", Boolean(this.on));
    this.place();
  }

  place() {
    if (!this.on) return redraw();
    const box = viser.canvas.getBoundingClientRect();
    Object.assign(this.line.style, { left: `${box.left + this.share * box.width}px`,
      top: `${box.top}px`, height: `${box.height}px` });
    this.line.firstChild.textContent = this.on.a.label;
    this.line.lastChild.textContent = this.on.b.label;
    redraw();
  }

  /** Draws in two halves from now on: three.js tells the scene which renderer draws it. */
  hook() {
    const before = viser.scene.onBeforeRender;
    viser.scene.onBeforeRender = (renderer, ...rest) => {
      viser.scene.onBeforeRender = before;
      const whole = renderer.render.bind(renderer);
      renderer.render = (scene, camera) => {
        if (!this.on || scene !== viser.scene) return whole(scene, camera);
        this.halves(renderer, () => whole(scene, camera));
      };
      before.call(viser.scene, renderer, ...rest);
    };
  }

  halves(renderer, draw) {
    const size = renderer.getSize({ set(x, y) { return Object.assign(this, { x, y }); } });
    const cut = Math.round(this.share * size.x);
    renderer.setScissorTest(true);
    for (const [side, start, end] of [[this.on.a, 0, cut], [this.on.b, cut, size.x]]) {
      const restore = dressed(side);
      renderer.setScissor(start, 0, end - start, size.y);
      draw();
      restore();
    }
    renderer.setScissorTest(false);
    renderer.setScissor(0, 0, size.x, size.y);
  }
}

/** Changes nodes for one half; returns what puts them back. */
function dressed(side) {
  const undo = [];
  for (const [names, visible] of [[side.hide || [], false], [side.show || [], true]]) {
    for (const name of names) {
      const object = node(name);
      if (!object || object.visible === visible) continue;
      object.visible = visible;
      undo.push(() => (object.visible = !visible));
    }
  }
  for (const [name, place] of Object.entries(side.move || {})) {
    const object = node(name);
    if (!object) continue;
    const was = object.position.clone();
    object.position.set(...place);
    undo.push(() => object.position.copy(was));
  }
  return () => undo.forEach((task) => task());
}
