// Puts the parts together: in a page that plays by itself, or in the page of a server.

let data = {};

function frameLoop(task) {
  let failed = false;
  const next = () => {
    if (failed) return;
    try {
      task();
    } catch (error) {
      failed = true;
      console.error(error);
    }
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
}

/** Whether the first picture is still to go, which an event will tell; it fades for a moment after that. */
function pictureStands() {
  const first = document.getElementById("first");
  return Boolean(first) && first.style.opacity !== "0";
}

const setVisible = (name, visible) =>
  viser.messageQueue.push({ type: "SetSceneNodeVisibilityMessage", name, owner: "", visible });

/** The contacts of a person in a frame, as `SkinForces.show` takes them. */
function pointsOf(skin, person, now) {
  const points = [];
  const frame = Math.min(now, skin.first.length - 2);
  for (let k = skin.first[frame]; k < skin.first[frame + 1]; k++) {
    if (skin.person[k] === person) {
      points.push([...skin.place.slice(3 * k, 3 * k + 3).map((mm) => mm / 1000), skin.force[k] / 10]);
    }
  }
  return points;
}

async function startPage(packed) {
  data = packed;
  // Before viser starts: where its camera stands at first.
  aimFirst();
  const drops = new PageDrops();
  const reel = new Reel(await inflated(packed.reel));
  const dents = await Dents.load(packed.dents);
  const { skin } = packed;
  const clock = new OwnClock((reel.frames - 1) / data.fps, data.fps);
  whenLoaded(() => {
    const cameras = new PageCameras();
    const bar = new Bar(clock);
    const compare = new Compare();
    const paint = new SkinForces(data.ramp);
    const frame = () => Math.min(Math.floor(clock.shown * data.fps + 1e-6), reel.frames - 1);
    const follow = () => {
      cameras.follow(frame());
      panel.follow.classList.toggle("hp-on", cameras.following);
    };
    const panel = new PagePanel({
      layer(layer, on) {
        if (layer.id === "skin") paint.on = on;
        for (const name of layer.nodes) setVisible(name, on);
        painted = -1;
        redraw();
      },
      camera(name) {
        if (name === "Everything") cameras.everything(frame());
        else if (name === "First") cameras.home(frame());
        else cameras.preset(name, frame());
        panel.follow.classList.toggle("hp-on", cameras.following);
      },
      follow,
    });
    panel.follow.classList.toggle("hp-on", cameras.following);
    bar.extra.append(compare.button);
    document.body.append(bar.element, panel.element);
    bar.setMarks(data.marks);
    compare.setChoices(data.compare);
    listenToKeys({ ...commonKeys(clock, compare), f: follow, 0: () => cameras.home(frame()),
      ...Object.fromEntries(PRESETS.map((name, k) => [`${k + 1}`, () => cameras.preset(name, frame())])) });
    listenToDrops((files) => drops.takeAll(files));
    let painted = -1;
    whenReady(() => {
      // The first picture stands until viser has drawn the scene (viewer/first_picture.py).
      const begin = () => (clock.playing = true);
      if (pictureStands()) addEventListener("first-picture", begin, { once: true });
      else begin();
      frameLoop(() => {
        const duration = Math.max((reel.frames - 1) / data.fps, drops.seconds);
        if (duration !== clock.duration) {
          clock.duration = duration;
          bar.setMarks(data.marks);
        }
        clock.tick();
        const now = frame();
        reel.show(now);
        dents.show(now);
        drops.show(clock.shown);
        cameras.tick(now);
        if (painted !== now && data.people.every(node)) {
          painted = now;
          data.people.forEach((name, k) => paint.show(name, pointsOf(skin[data.of[k][0]], data.of[k][1], now)));
        }
        bar.refresh();
      });
    });
    window.halfphysics = { clock, reel, dents, compare, cameras, paint, drops };
  });
}

function commonKeys(clock, compare) {
  return {
    " ": () => clock.toggle(),
    ArrowLeft: () => clock.step(-1),
    ArrowRight: () => clock.step(1),
    Home: () => clock.seek(0),
    End: () => clock.seek(clock.duration),
    c: () => compare.next(),
    "?": () => help.toggle(),
    Escape: () => help.toggle(false),
  };
}

/** The first camera of viser, which it reads from the address; one that the user put there stays. */
function aimFirst() {
  const known = new URLSearchParams(location.search);
  if (known.has("initialCameraPosition") && !known.has("fitted")) return;
  const [position, target] = homeView(0);
  known.set("initialCameraPosition", position.map((x) => x.toFixed(4)).join());
  known.set("initialCameraLookAt", target.map((x) => x.toFixed(4)).join());
  known.set("fitted", "1");
  try {
    history.replaceState(null, "", `?${known}`);
  } catch { /* inside another page */ }
}

function startServed() {
  const clock = new ServerClock();
  whenLoaded(() => {
    const bar = new Bar(clock);
    const compare = new Compare();
    const paint = new SkinForces([[1, 1, 1], [1, 0, 0]]);
    bar.extra.append(compare.button);
    document.body.append(bar.element);
    bar.setMarks([]);
    const send = (what, to) => () => command({ do: what, to });
    const live = (action) => () =>
      clock.live ? say("A live simulation cannot go back; Home starts it again.") : action();
    const common = commonKeys(clock, compare);
    listenToKeys({ ...common, ArrowLeft: live(common.ArrowLeft), End: live(common.End),
      f: send("follow"), 0: send("home"),
      ...Object.fromEntries(PRESETS.map((name, k) => [`${k + 1}`, send("preset", name)])) });
    listenToDrops(sendToServer);
    let skin = null; // contacts of all frames, of each result
    let points = []; // or those of now, of each person
    let painted = "";
    let [scene, loads] = [null, null];
    let last = "";
    heard.push(async (said) => {
      // The server builds its scene anew, or is another one: a page that is open cannot follow.
      if (scene !== null && said.scene && said.scene !== scene) return location.reload();
      if (loads !== null && "loads" in said && said.loads !== loads) return location.reload();
      if (said.scene) scene = said.scene;
      if ("loads" in said) loads = said.loads;
      if (said.clock) clock.hear(said.clock);
      if (!said.points) {
        if (said.say && said.say !== last) say(said.say, 8);
        last = said.say;
      }
      if (said.marks) bar.setMarks(said.marks);
      if (said.points) [points, painted] = [said.points, ""];
      if ("paint" in said && said.paint !== paint.on) [paint.on, painted] = [said.paint, ""];
      if (said.data && JSON.stringify(said.data) !== data.name) await takeData(said.data);
    });

    async function takeData(said) {
      const found = typeof said === "string" ? await (await fetch(said)).json() : said;
      data = { ...found, name: JSON.stringify(said) };
      document.title = data.title;
      paint.ramp = new SkinForces(data.ramp).ramp;
      if (data.marks) bar.setMarks(data.marks);
      compare.setChoices(data.compare);
      skin = data.skin;
      painted = "";
    }

    whenReady(() => {
      foldSheet();
      comeBack();
      frameLoop(() => {
        bar.refresh();
        const people = data.people || [];
        const frame = Math.floor(clock.shown * clock.fps + 1e-6);
        const state = `${frame}|${people.join()}`;
        if (state === painted || !people.every(node)) return;
        painted = state;
        people.forEach((name, k) => paint.show(name,
          skin ? servedPoints(skin, data.of[k], clock.shown) : points[k] || []));
      });
    });
    window.halfphysics = { clock, compare, paint };
  });
}

/** The contacts of a person now; results may have frame rates of their own. */
function servedPoints(skin, [result, person], time) {
  const one = skin[result];
  const frame = Math.min(Math.floor(time * one.fps + 1e-6), one.first.length - 2);
  return pointsOf(one, person, frame);
}

/**
 * Where lights cast shadows, viser's app takes itself apart when the connection is lost, instead of connecting
 * again: the page is loaded anew when a server answers.
 */
function comeBack() {
  const root = document.getElementById("root");
  const watch = new MutationObserver(() => {
    if (root.childElementCount) return;
    watch.disconnect();
    say("The server has gone; this page looks for it.", 3600);
    setInterval(() => fetch(location.href, { cache: "no-store" }).then(() => location.reload(), () => {}), 1000);
  });
  watch.observe(root, { childList: true });
}

/** On a narrow window viser's panel is a sheet over the scene: it starts folded. */
function foldSheet() {
  if (innerWidth > 580) return;
  const look = setInterval(() => {
    const sheet = document.querySelector("#root [style*='position: fixed'] [style*='cursor: pointer']");
    if (!sheet) return;
    clearInterval(look);
    sheet.click();
  }, 100);
}
