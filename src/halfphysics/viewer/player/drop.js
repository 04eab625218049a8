// Files that are dropped onto the scene. A page shows them itself; `view` sends them to its server.

/** @param take What to do with the files of one drop. */
function listenToDrops(take) {
  const over = make("div", { id: "hp-over", hidden: "" }, make("span", {}, "Let go to see it"));
  document.body.append(over);
  const withFiles = (event) => event.dataTransfer && [...event.dataTransfer.types].includes("Files");
  let depth = 0;
  addEventListener("dragenter", (event) => {
    if (!withFiles(event)) return;
    depth += 1;
    over.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (withFiles(event) && --depth <= 0) over.hidden = true;
  });
  addEventListener("dragover", (event) => withFiles(event) && event.preventDefault());
  addEventListener("drop", async (event) => {
    if (!withFiles(event)) return;
    event.preventDefault();
    depth = 0;
    over.hidden = true;
    await take([...event.dataTransfer.files]);
  });
}

const LIMIT = 256; // largest file [MB]
const ROOM = 512; // what the server takes at a time (viewer/guard.py) [MB]

function tooLarge(file) {
  if (file.size <= LIMIT * 2 ** 20) return false;
  say(`${file.name} has ${Math.round(file.size / 2 ** 20)} MB; up to ${LIMIT} MB can be dropped.`);
  return true;
}

async function sendToServer(files) {
  if (!wire.upload) return say("A running simulation takes no files. Use: halfphysics play FILE");
  let room = ROOM * 2 ** 20;
  const taken = files.filter((file) => !tooLarge(file) && (room -= file.size) >= 0);
  if (room < 0) say(`Files of one drop have up to ${ROOM} MB together: drop the rest after these.`, 12);
  await upload(taken);
}

/** Whole numbers whose bytes stand apart: the lowest of all numbers, then the second ones, ... */
async function whole(text, type) {
  const bytes = await inflated(text);
  const size = type.BYTES_PER_ELEMENT;
  const count = bytes.length / size;
  const joined = new Uint8Array(bytes.length);
  for (let k = 0; k < bytes.length; k++) joined[(k % count) * size + Math.floor(k / count)] = bytes[k];
  return new type(joined.buffer);
}

class PageDrops {
  constructor() {
    this.people = [];
    this.like = null;
    watchers.push((message) => {
      if (message.type === "SkinnedMeshMessage" && message.props.opacity === null) {
        this.like ||= message.props;
      }
      return false;
    });
  }

  async takeAll(files) {
    for (const file of files) await this.take(file);
  }

  async take(file) {
    if (tooLarge(file)) return;
    try {
      // It would run here, with the rights of this page's address: the browser opens it by itself.
      if (/\.html?$/i.test(file.name)) throw new NpzError("a page is opened in a tab of its own");
      if (!/\.npz$/i.test(file.name)) throw new NpzError("it is no .npz");
      const found = await peopleIn(await npz(file));
      const body = await this.body();
      let aside = false;
      for (const motion of found) aside = this.add(motion, body) || aside;
      const people = found.length === 1 ? "a person" : `${found.length} people`;
      say(`${file.name}: ${people} more, with this page's skin${aside ? ", moved aside" : ""}.`);
    } catch (error) {
      if (!(error instanceof NpzError)) console.warn(error);
      const why = error instanceof NpzError ? error.message : "it cannot be read";
      say(`${file.name} is not shown: ${why}. A page takes results and AMASS-like motions (.npz); ` +
        "for all else: halfphysics view FILE", 12);
    }
  }

  /** Adds a person; true: they were moved aside. */
  add(motion, body) {
    const person = new FurtherPerson(motion, body, this.like, this.people.length);
    const there = [...data.starts, ...this.people.map((other) => other.pelvis(0))];
    const near = () => there.some((p) =>
      Math.hypot(p[0] - person.pelvis(0)[0], p[1] - person.pelvis(0)[1]) < APART);
    while (near()) person.offset = add(person.offset, [ASIDE, 0, 0]);
    this.people.push(person);
    return person.offset[0] > 0;
  }

  async body() {
    if (this.unpacked) return this.unpacked;
    const { vertices, faces, indices, weights, joints, parents } = data.body;
    const [v, f, i, w] = await Promise.all([whole(vertices, Int16Array), whole(faces, Int32Array),
      whole(indices, Uint8Array), whole(weights, Uint16Array)]);
    for (let k = 1; k < f.length; k++) f[k] += f[k - 1];
    this.unpacked = { vertices: Float32Array.from(v, (x) => x * GRAIN), faces: Uint32Array.from(f),
      indices: Uint16Array.from(i), weights: Float32Array.from(w, (x) => x / 65535), joints, parents };
    return this.unpacked;
  }

  get seconds() { return Math.max(0, ...this.people.map((person) => person.seconds)); }

  show(time) {
    for (const person of this.people) person.show(time);
  }
}
