// The files of the package are those of the Python package, where pages take them from: copied before packing.
import { copyFileSync } from "node:fs";

const from = new URL("../../src/halfphysics/assets/core/", import.meta.url);
for (const name of ["halfphysics.js", "halfphysics.d.ts", "halfphysics.wasm"])
  copyFileSync(new URL(name, from), new URL(name, import.meta.url));
