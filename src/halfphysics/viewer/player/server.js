// The wire between this page and the server of `view` and `play`: invisible text fields of viser, `out`
// that we write, `in` and `now` that the server writes (viewer/remote.py).

const wire = { out: null, in: null, now: null, upload: null };
const sending = new Map(); // our uploads -> what to call at the end
const SILENCE = 30000; // without a word for so long an upload is given up [ms]
const MINE = "halfphysics-wire";
const heard = []; // called with everything that the server says

watchers.push((message) => {
  if (message.type === "GuiTextMessage" && (message.props.label || "").startsWith(MINE)) {
    wire[message.props.label.slice(MINE.length + 1)] = message.uuid;
    if (message.uuid !== wire.out) hear(message.value);
    return false;
  }
  if (message.type === "GuiUploadButtonMessage") wire.upload = message.uuid;
  // All browsers hear how far uploads of all are.
  if (message.type === "FileTransferPartAck" && message.transfer_uuid.startsWith("hp-")) {
    sending.get(message.transfer_uuid)?.(message.transferred_bytes / Math.max(message.total_bytes, 1));
    return true;
  }
  if (message.type !== "GuiUpdateMessage" || ![wire.in, wire.now].includes(message.uuid)) return false;
  hear(message.updates.value);
  return true;
});

function hear(text) {
  if (!text) return;
  const said = JSON.parse(text);
  for (const listener of heard) listener(said);
}

/** Sends a command to the server. */
function command(what) {
  if (!wire.out) return;
  const value = JSON.stringify({ ...what, n: `${Math.random()}`.slice(2) });
  viser.sendMessage({ type: "GuiUpdateMessage", uuid: wire.out, updates: { value } });
}

const PART = 512 * 1024;

/**
 * Sends files to the server one after the other, as viser's own upload button does. All are announced first:
 * the server shows them together.
 */
async function upload(files) {
  const transfers = files.map((file) => {
    const transfer = { source_component_uuid: wire.upload, transfer_uuid: `hp-${Math.random()}` };
    viser.sendMessage({ type: "FileTransferStartUpload", ...transfer, filename: file.name,
      mime_type: file.type, size_bytes: file.size, part_count: Math.ceil(file.size / PART) });
    return { file, transfer };
  });
  for (const { file, transfer } of transfers) {
    if (await sent(file, transfer)) continue;
    say(`${file.name} did not get through: the server is busy with other files. Try again.`, 12);
  }
}

/** Sends the parts of a file; false: the server does not take them. */
async function sent(file, transfer) {
  if (!file.size) return true;
  const arrived = new Promise((done) => {
    let timer;
    const heard = (share) => {
      clearTimeout(timer);
      timer = setTimeout(() => done(false), SILENCE);
      if (share < 1) say(`Sending ${file.name}: ${Math.round(100 * share)} %`, SILENCE / 1000);
      else done(true);
    };
    sending.set(transfer.transfer_uuid, heard);
    heard(0);
  });
  for (let k = 0; k * PART < file.size; k++) {
    const content = new Uint8Array(await file.slice(k * PART, (k + 1) * PART).arrayBuffer());
    viser.sendMessage({ type: "FileTransferPart", ...transfer, part_index: k, content });
  }
  const taken = await arrived;
  sending.delete(transfer.transfer_uuid);
  return taken;
}
