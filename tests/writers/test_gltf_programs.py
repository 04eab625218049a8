"""Independent programs open the files: three.js in a browser, the Khronos validator.

They are found where `NODE_PATH` names a `node_modules` with `three` or `gltf-validator` in it
(`npm install three gltf-validator`), and chromium or node are installed.
"""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import subprocess
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from support.people import FACING_X, violent
from support.results.gltf_results import many_handed, y_up
from support.results.random_result import make_result

pytestmark = pytest.mark.slow

PAGE = Path(__file__).with_name("gltf_page.html")
MODULES = [Path(p) for p in os.environ.get("NODE_PATH", "").split(os.pathsep) if p]
TYPES = {".js": "text/javascript", ".html": "text/html"}


def module(name):
    """The folder of a package, or None."""
    return next((folder / name for folder in MODULES if (folder / name).is_dir()), None)


def walk(like):
    """A person with every joint bent in front of a camera."""
    motion = violent(len(like))
    rotations = 0.4 * motion.rotations
    turn = rot.exp(np.linspace([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], len(like)))
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(FACING_X)))
    return like.with_frames(motion.translation, rotations)


def in_browser(glb, folder):
    """The page's findings about a file."""
    found, done = {}, threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            path = Path(self.path)
            if self.path == "/":
                path = PAGE
            elif self.path == "/file.glb":
                path = glb
            elif path.parts[1] == "node_modules":
                path = module(path.parts[2]).joinpath(*path.parts[3:])
            self.send_response(200 if path.is_file() else 404)
            self.send_header("Content-Type", TYPES.get(path.suffix, "application/octet-stream"))
            self.end_headers()
            if path.is_file():
                self.wfile.write(path.read_bytes())

        def do_POST(self):
            found.update(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()
            done.set()

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    flags = [
        *("--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking"),
        *("--disable-quic", "--disable-component-update", "--disable-sync"),
        *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
        f"--user-data-dir={folder / 'profile'}",
    ]
    browser = subprocess.Popen(
        ["chromium", *flags, "--remote-debugging-port=0", f"http://127.0.0.1:{server.server_port}"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert done.wait(100.0), "the page sent nothing"
    finally:
        browser.terminate()
        browser.wait(20.0)
        server.shutdown()
        server.server_close()
    return found


@pytest.mark.skipif(
    module("three") is None or shutil.which("chromium") is None, reason="no three.js or no chromium"
)
@pytest.mark.parametrize("posedirs", [0.0, 2e-3], ids=["skin", "morphed"])
def test_three_js_shows_what_we_mean(tmp_path, posedirs):
    """Every vertex of people and objects at five frames, and a non-empty canvas."""
    body = Body.default()
    if posedirs:  # with the default body's weights, so that a person is drawn
        body = dataclasses.replace(body, posedirs=many_handed(4, posedirs).posedirs)
    result = make_result(body, frames=9, people=2)
    seen, random = result.people  # the page's camera looks at the last
    seen = dataclasses.replace(seen, motion=walk(seen.motion), reference=walk(seen.motion))
    names = (*result.names[:-2], random.name, seen.name)
    result = dataclasses.replace(result, people=(random, seen), names=names)
    hp.export(result, tmp_path / "file.glb")
    found = in_browser(tmp_path / "file.glb", tmp_path)
    assert found["complaints"] == []
    assert list(found["frames"]) == ["0", "2", "4", "6", "8"]
    assert min(found["painted"].values()) > 500
    for frame, meshes in found["frames"].items():
        assert set(meshes) == {*("person0_skin", "person1_skin", "floor", "wall", "ball", "stick")}
        for person in result.people:
            theirs = np.reshape(meshes[f"{person.name}_skin"], (-1, 3))
            ours = y_up(body.vertices(person.motion, int(frame)))
            assert np.abs(theirs - ours).max() < 1e-5
        ball = result.objects["ball"]
        middle = np.reshape(meshes["ball"], (-1, 3)).mean(axis=0)
        assert np.abs(middle - y_up(ball.position[int(frame)])).max() < 1e-5


@pytest.mark.skipif(
    module("gltf-validator") is None or shutil.which("node") is None, reason="no validator"
)
def test_the_khronos_validator_has_nothing_to_say(tmp_path):
    hp.export(make_result(Body.default(), people=2), tmp_path / "result.glb")
    hp.export(make_result(Body.default(), people=2), tmp_path / "result.gltf")
    hp.export(violent(9), tmp_path / "shapes.glb", body=many_handed(7, 5e-3))
    files = sorted(tmp_path.iterdir())
    script = """
    const validator = require("gltf-validator"), fs = require("fs");
    (async () => {
      for (const file of process.argv.slice(1))
        console.log(JSON.stringify(
          (await validator.validateBytes(new Uint8Array(fs.readFileSync(file)))).issues));
    })();"""
    out = subprocess.run(
        ["node", "-e", script, *map(str, files)], check=True, capture_output=True, text=True
    )
    lines = [json.loads(line) for line in out.stdout.splitlines()]
    assert len(lines) == 3
    for issues in lines:
        assert issues["messages"] == []
