"""The npm packages as their users get them: packed, installed, and checked by their types."""

from __future__ import annotations

import json
import re
import shutil

import pytest

from support.npm import package, run
from support.paths import ROOT

pytestmark = pytest.mark.slow

CORE = ROOT / "src" / "halfphysics" / "assets" / "core"
STRICT = {
    "target": "ES2022",
    "module": "NodeNext",
    "moduleResolution": "NodeNext",
    "lib": ["ES2022", "DOM"],
    "types": [],
    "strict": True,
    "noEmit": True,
}


def packed(folder, out):
    """The archive of a package, as `npm publish` would send it."""
    out.mkdir()
    said = run(folder, "npm", "pack", "--json", "--pack-destination", str(out))
    return out / json.loads(said)[0]["filename"]


def user(folder, archive, script):
    """A package of somebody else that has ours and a script in TypeScript."""
    folder.mkdir()
    (folder / "package.json").write_text('{"type": "module", "private": true}')
    run(folder, "npm", "install", "--offline", "--no-audit", "--no-fund", str(archive))
    (folder / "script.ts").write_text(script, encoding="utf-8")
    (folder / "tsconfig.json").write_text(
        json.dumps({"compilerOptions": STRICT, "include": ["script.ts"]})
    )
    return folder


def checked(folder, client):
    """Check a folder's types with the compiler that the client's lock file has."""
    run(folder, "node", str(client / "node_modules" / "typescript" / "bin" / "tsc"), "-p", ".")


def test_the_client_is_built_with_types():
    """Strictly typed, without an error; what is packed is what `main` and `types` name."""
    client = package("client")
    run(client, "npm", "run", "--silent", "build")
    said = json.loads(run(client, "npm", "pack", "--dry-run", "--json"))[0]
    files = {file["path"] for file in said["files"]}
    assert {"dist/index.js", "dist/index.d.ts", "README.md", "package.json"} <= files
    assert not [name for name in files if "test" in name or name.startswith("page")]


def test_the_core_is_used_by_its_types(tmp_path):
    """The first example of its README compiles against the package; a wrong call does not."""
    client = package("client")
    shutil.copytree(ROOT / "js" / "core", tmp_path / "js" / "core")
    shutil.copytree(CORE, tmp_path / "src" / "halfphysics" / "assets" / "core")
    archive = packed(tmp_path / "js" / "core", tmp_path / "archives")
    readme = (ROOT / "js" / "core" / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```js\n(.*?)```", readme, re.DOTALL)[1]
    script = (
        'import type { Pose } from "@halfphysics/core";\n'
        "declare const poses: [Pose, Pose];\n"
        "interface ImportMeta { resolve(name: string): string }\n" + example
    )
    mine = user(tmp_path / "mine", archive, script)
    checked(mine, client)
    (mine / "script.ts").write_text(script.replace("world.reset(", "world.restart("))
    with pytest.raises(AssertionError, match=r"'restart' does not exist"):
        checked(mine, client)
