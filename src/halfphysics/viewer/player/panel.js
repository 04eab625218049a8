// The page's panel: its title, what the colours mean, layers, cameras. On a narrow window it is a
// sheet at the bottom, folded at first.

class PagePanel {
  constructor(act) {
    this.boxes = data.layers.map((layer) => {
      const box = make("input", { type: "checkbox", "data-layer": layer.id });
      box.checked = layer.on;
      box.addEventListener("change", () => act.layer(layer, box.checked));
      return make("label", {}, box, layer.label);
    });
    const cameras = ["First", ...PRESETS, "Everything"].map((name) =>
      make("button", { onclick: () => act.camera(name) }, name));
    this.follow = make("button", { id: "hp-follow", onclick: () => act.follow() }, "Follow");
    const key = make("div", { id: "key" });
    key.innerHTML = data.key;
    const bar = make("button", { id: "hp-handle", "aria-expanded": "true", "aria-controls": "hp-folded",
      onclick: () => this.fold() }, make("b", {}, data.title), make("i", {}));
    this.folded = make("div", { id: "hp-folded" }, key,
      make("div", { class: "hp-cameras" }, ...cameras, this.follow),
      make("div", { class: "hp-layers" }, ...this.boxes));
    this.element = make("div", { id: "hp-panel" }, bar, this.folded);
    this.handle = bar;
    this.fold(innerWidth <= 580);
  }

  fold(closed = !this.folded.hidden) {
    this.folded.hidden = closed;
    this.handle.setAttribute("aria-expanded", `${!closed}`);
  }
}
