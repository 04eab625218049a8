// Writes the test page as one file, which the server of the Python package sends: npm run page

import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const out = process.argv[2] ?? here("../../../src/halfphysics/live/page.html");

const { outputFiles } = await build({
  entryPoints: [here("page.ts")],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  write: false,
  legalComments: "none",
});
// No end tag of the script may be inside it.
const script = outputFiles[0].text.trim().replaceAll("</script", "<\\/script");
const page = await readFile(here("page.html"), "utf8");
await writeFile(out, page.replace("/*script*/", () => script));
