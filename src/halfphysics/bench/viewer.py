"""Cost of moving people in a browser, on the server's side."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion

# Updates per second; duration of a full and a quick measurement, pause that shows that all meshes
# have arrived, and time limit for their arrival [s].
_RATE = 30.0
_SECONDS, _QUICK_SECONDS = 10.0, 1.0
_SETTLED, _PATIENCE = 0.7, 60.0

# A client in its own process, like a browser: after every message it prints the number of bytes
# and of messages received so far.
_CLIENT = """
import sys
from websockets.sync.client import connect
size = count = 0
with connect(sys.argv[1], subprotocols=[sys.argv[2]], max_size=None, compression=None) as socket:
    for message in socket:
        size += len(message)
        count += 1
        print(size, count, flush=True)
"""


def viewer(options: Options) -> Iterator[Record]:
    """Records of two people, without and with ghosts; every joint moves."""
    seconds = _QUICK_SECONDS if options.quick else _SECONDS
    for setting, ghosts, fast in (
        ("two people", False, True),
        ("two people, viser's setters", False, False),
        ("two people and two ghosts", True, True),
    ):
        yield _measured(setting, ghosts, fast, seconds)


def _measured(setting: str, ghosts: bool, fast: bool, seconds: float) -> Record:
    from halfphysics.viewer.server import close_server, open_server

    server = open_server("127.0.0.1", 0)
    try:
        figures = _figures(server, body(), ghosts, fast)
        client = _Client(server)
        try:
            return _run(setting, server, figures, client, seconds)
        finally:
            client.close()
    finally:
        close_server(server)


def _figures(server: Any, person: Body, ghosts: bool, fast: bool) -> list[Any]:
    from halfphysics.render.look import GHOST, GHOST_ALPHA, PEOPLE
    from halfphysics.render.rasterizer import Surface
    from halfphysics.viewer.figure import Figure

    looks = [(f"/person/{k}", PEOPLE[k], 1.0) for k in range(2)]
    if ghosts:
        looks += [(f"/ghost/{k}", GHOST, GHOST_ALPHA) for k in range(2)]
    figures = [
        Figure(
            server,
            name,
            Surface(vertices=person.rest_vertices, faces=person.faces, color=color, alpha=alpha),
            person,
            fast=fast,
        )
        for name, color, alpha in looks
    ]
    for ghost in figures[2:]:
        ghost.fade(dict.fromkeys(ghost.handles, 1.0))  # all of it is drawn
    return figures


def _run(setting: str, server: Any, figures: list[Any], client: _Client, seconds: float) -> Record:
    positions, quaternions = body().joint_frames(_lively())
    updates = round(seconds * _RATE)
    client.settle()
    before, windows = client.read()
    own = time.process_time()
    start = time.perf_counter()
    for update in range(updates):
        frame = update % len(positions)
        with server.atomic():
            for figure in figures:
                figure.pose(positions[frame], quaternions[frame])
        time.sleep(max(start + (update + 1) / _RATE - time.perf_counter(), 0.0))
    took = time.perf_counter() - start
    own = time.process_time() - own
    client.settle()
    after, seen = client.read()
    return Record(
        case="viewer",
        setting=setting,
        frames=updates,
        unit="updates/s",
        ours=(updates / took,),
        checks={
            "kB/s": ((after - before) / took / 1e3, None),
            "share of a core": (own / took, None),
            "arrived/s": ((seen - windows) / took, None),
        },
    )


def _lively() -> Motion:
    """The walk of the demo's story with every joint in motion, so that no update can be omitted."""
    walk = story().motions[0]
    joints, axes = np.arange(walk.rotations.shape[1])[:, None], np.arange(3)
    seconds = np.arange(len(walk))[:, None, None] / walk.fps
    swing = 0.15 * np.sin((3.0 + 0.37 * joints + 0.9 * axes) * seconds + 1.7 * joints + axes)
    return Motion(walk.translation, walk.rotations + swing, walk.fps)


class _Client:
    """A connected client that counts what it receives."""

    def __init__(self, server: Any) -> None:
        import threading

        import viser

        self._count = (0, 0)
        self._process = subprocess.Popen(
            [sys.executable, "-c", _CLIENT, f"ws://127.0.0.1:{server.get_port()}",
             f"viser-v{viser.__version__}"],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def _listen(self) -> None:
        for line in self._process.stdout or ():
            size, count = line.split()
            self._count = int(size), int(count)

    def read(self) -> tuple[int, int]:
        """Bytes and messages received so far."""
        return self._count

    def settle(self) -> None:
        """Wait until no more messages arrive.

        Raises:
            TimeoutError: Messages never arrived or never stopped, or the client ended.
        """
        end, last, since = time.monotonic() + _PATIENCE, (0, 0), time.monotonic()
        while not last[0] or time.monotonic() - since < _SETTLED:
            if time.monotonic() > end or self._process.poll() is not None:
                raise TimeoutError("the client that measures got nothing from the viewer")
            time.sleep(0.05)
            if self._count != last:
                last, since = self._count, time.monotonic()

    def close(self) -> None:
        """End the client process."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
