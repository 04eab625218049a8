// Reads the arrays of numbers, and texts, in an .npz file: a zip of .npy files, stored or deflated.

class NpzError extends Error {}

/** The names in an archive -> what reads each: an array, or null where it holds no numbers. */
async function npz(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const view = new DataView(bytes.buffer);
  let end = bytes.length - 22;
  while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) end--;
  if (end < 0) throw new NpzError("it is no .npz archive, or it is cut off");
  const found = new Map();
  let at = view.getUint32(end + 16, true);
  for (let k = 0; k < view.getUint16(end + 10, true); k++) {
    if (at + 46 > bytes.length || view.getUint32(at, true) !== 0x02014b50) {
      throw new NpzError("its list of arrays is damaged");
    }
    const length = view.getUint16(at + 28, true);
    const name = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + length));
    const entry = { method: view.getUint16(at + 10, true), size: view.getUint32(at + 20, true),
      start: view.getUint32(at + 42, true) };
    found.set(name.replace(/\.npy$/, ""), () => content(bytes, view, entry).then(npy));
    at += 46 + length + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
  }
  return found;
}

async function content(bytes, view, { method, size, start }) {
  if (start + 30 > bytes.length) throw new NpzError("it is cut off");
  const from = start + 30 + view.getUint16(start + 26, true) + view.getUint16(start + 28, true);
  const packed = bytes.subarray(from, from + size);
  if (method === 0) return packed.slice();
  if (method === 8) return inflate(packed, "deflate-raw");
  throw new NpzError("it is packed in a way that this page does not know");
}

const NUMBERS = { f8: Float64Array, f4: Float32Array, i8: BigInt64Array, i4: Int32Array,
  i2: Int16Array, u1: Uint8Array, i1: Int8Array, u8: BigUint64Array, u4: Uint32Array };

/** An array of numbers {shape, values}, row by row, or a text {text}; null: it holds something else. */
function npy(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  if (bytes[0] !== 0x93 || bytes[1] !== 0x4e) throw new NpzError("one of its arrays is damaged");
  const long = bytes[6] > 1;
  const length = long ? view.getUint32(8, true) : view.getUint16(8, true);
  const start = (long ? 12 : 10) + length;
  const text = new TextDecoder().decode(bytes.subarray(long ? 12 : 10, start));
  const kind = /'descr':\s*'[<|=]([fiu]\d)'/.exec(text);
  const letters = /'descr':\s*'<U(\d+)'/.exec(text);
  if (letters) return { text: wide(bytes.slice(start, start + 4 * Number(letters[1]))) };
  const shape = (/'shape':\s*\(([^)]*)\)/.exec(text)[1].match(/\d+/g) || []).map(Number);
  if (!kind || !(kind[1] in NUMBERS)) return null;
  const count = shape.reduce((product, n) => product * n, 1);
  const type = NUMBERS[kind[1]];
  const data = bytes.slice(start, start + count * type.BYTES_PER_ELEMENT);
  if (data.length < count * type.BYTES_PER_ELEMENT) throw new NpzError("it is cut off");
  let values = Float64Array.from(new type(data.buffer), Number);
  if (/'fortran_order':\s*True/.test(text) && shape.length > 1) values = rows(values, shape);
  return { shape, values };
}

/** A text of four bytes a letter, as numpy has it. */
function wide(bytes) {
  const letters = new Uint32Array(bytes.buffer, 0, Math.floor(bytes.length / 4));
  return Array.from(letters, (letter) => String.fromCodePoint(letter)).join("").replace(/\0+$/, "");
}

/** Values that stand column by column, row by row. */
function rows(values, shape) {
  const out = new Float64Array(values.length);
  const strides = shape.map((_, k) => shape.slice(0, k).reduce((product, n) => product * n, 1));
  const index = shape.map(() => 0);
  for (let k = 0; k < out.length; k++) {
    out[k] = values[index.reduce((sum, i, axis) => sum + i * strides[axis], 0)];
    for (let axis = shape.length - 1; axis >= 0 && ++index[axis] === shape[axis]; axis--) {
      index[axis] = 0;
    }
  }
  return out;
}
