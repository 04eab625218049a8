// Shows any frame of a reel (viewer/reel.py) by giving viser the messages that differ from the frame
// that is shown.

const ARRAYS = { "<f4": Float32Array, "<f8": Float64Array, "<u4": Uint32Array, "<i4": Int32Array,
  "<u2": Uint16Array, "<i2": Int16Array, "|u1": Uint8Array, "|i1": Int8Array };
const GRAIN = 2 ** -13;

class Reel {
  /** @param bytes The reel, inflated. */
  constructor(bytes) {
    const length = new DataView(bytes.buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    this.frames = header.frames;
    this.numbers = header.numbers;
    this.events = header.events;
    this.shown = -1;
    const { columns } = header;
    const count = columns * this.frames;
    const planes = bytes.subarray(4 + length, 4 + length + 4 * count);
    this.values = new Int32Array(count);
    for (let k = 0; k < count; k++) {
      this.values[k] = planes[k] | (planes[count + k] << 8) | (planes[2 * count + k] << 16) |
        (planes[3 * count + k] << 24);
    }
    for (let column = 0; column < columns; column++) {
      for (let k = 1; k < this.frames; k++) {
        this.values[column * this.frames + k] += this.values[column * this.frames + k - 1];
      }
    }
    const arrays = bytes.slice(4 + length + 4 * count).buffer;
    for (const event of this.events) {
      event.values = event.values.map((value) => read(arrays, value));
      event.index = -1;
    }
  }

  /** The messages that lead from the frame that is shown to another one. */
  to(frame) {
    const messages = [];
    for (const { message, field, columns } of this.numbers) {
      const value = [];
      let same = this.shown >= 0;
      for (const column of columns) {
        const now = this.values[column * this.frames + frame];
        same &&= now === this.values[column * this.frames + this.shown];
        value.push(now * GRAIN);
      }
      if (!same) messages.push({ ...message, [field]: value });
    }
    for (const event of this.events) {
      const index = event.at.findLastIndex((at) => at <= frame);
      if (index === event.index) continue;
      event.index = index;
      const value = event.values[index];
      messages.push(event.field.startsWith("updates.")
        ? { ...event.message, updates: { [event.field.slice(8)]: value } }
        : { ...event.message, [event.field]: value });
    }
    this.shown = frame;
    return messages;
  }

  show(frame) {
    if (frame === this.shown) return;
    viser.messageQueue.push(...this.to(frame));
    redraw();
  }
}

function read(arrays, value) {
  if (value === null || typeof value !== "object" || !("dtype" in value)) return value;
  const bytes = arrays.slice(value.start, value.start + value.bytes);
  return new ARRAYS[value.dtype](bytes);
}
