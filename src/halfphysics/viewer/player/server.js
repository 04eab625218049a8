// The wire between this page and the server of `view` and `play`: invisible text fields of viser, `out`
// that we write, `in` and `now` that the server writes (viewer/remote.py).

const wire = { out: null, in: null, now: null, upload: null };
const MINE = "halfphysics-wire";
const heard = []; // called with everything that the server says

watchers.push((message) => {
  if (message.type === "GuiTextMessage" && (message.props.label || "").startsWith(MINE)) {
    wire[message.props.label.slice(MINE.length + 1)] = message.uuid;
    if (message.uuid !== wire.out) hear(message.value);
    return false;
  }
  if (message.type === "GuiUploadButtonMessage") wire.upload = message.uuid;
  if (message.type === "FileTransferPartAck" && message.transfer_uuid.startsWith("hp-")) {
    const share = message.transferred_bytes / Math.max(message.total_bytes, 1);
    if (share < 1) say(`Sending the file: ${Math.round(100 * share)} %`);
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

/** Sends a file to the server, as viser's own upload button does. */
async function upload(file) {
  const part = 512 * 1024;
  const transfer = { source_component_uuid: wire.upload, transfer_uuid: `hp-${Math.random()}` };
  const count = Math.ceil(file.size / part);
  viser.sendMessage({ type: "FileTransferStartUpload", ...transfer, filename: file.name,
    mime_type: file.type, size_bytes: file.size, part_count: count });
  for (let k = 0; k < count; k++) {
    const content = new Uint8Array(await file.slice(k * part, (k + 1) * part).arrayBuffer());
    viser.sendMessage({ type: "FileTransferPart", ...transfer, part_index: k, content });
  }
}
