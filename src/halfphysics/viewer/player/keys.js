// Keys, the same in the page, `view` and `play`, and the overlay that shows them.

const PRESETS = ["Front", "Side", "Top", "Hands"];

const KEYS = [
  ["space", "Play or pause"],
  ["← →", "One frame back or on"],
  ["Home End", "To the start or the end"],
  ["f", "Follow the person"],
  ["1 2 3 4", PRESETS.join(", ")],
  ["0", "The first view"],
  ["c", "Compare: two halves with a slider"],
  ["?", "These keys"],
];

const help = {
  element: null,
  toggle(shown) {
    if (!this.element) {
      const rows = KEYS.map(([key, what]) =>
        make("div", {}, make("span", {},
          ...key.split(" ").map((one) => make("kbd", {}, one))), make("span", {}, what)));
      this.element = make("div", { id: "hp-help", role: "dialog", hidden: "",
        onclick: () => this.toggle(false) }, make("div", {}, make("b", {}, "Keys"), ...rows,
        make("p", {}, data.dropText || "Drop a file here to see it.")));
      document.body.append(this.element);
    }
    this.element.hidden = shown === undefined ? !this.element.hidden : !shown;
  },
};

const AWAY = /^(Arrow|Home$|End$|Page)/; // keys that move along a slider, a list, or in time

/** Whether a key is for what has the focus: a field to type in, a list, a slider. */
function typing(target, key) {
  if (!(target instanceof Element)) return false;
  if (target.isContentEditable) return true;
  if (target.type === "range") return AWAY.test(key);
  return /^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName) && target.type !== "checkbox" &&
    target.type !== "radio";
}

function listenToKeys(actions) {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target, event.key)) return;
    const action = actions[event.key];
    if (!action) return;
    // viser has keys of its own: of each press, one of the two acts.
    event.preventDefault();
    event.stopImmediatePropagation();
    // A key that is held goes on through time; it does not switch to and fro.
    if (!event.repeat || AWAY.test(event.key)) action();
  }, true);
}
