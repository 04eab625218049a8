"""`hp.view`: plays, scrubs and compares recorded results in a browser."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.arrange import arrange, floor_height
from halfphysics.viewer.camera import Cameras
from halfphysics.viewer.comparison import References, has_reference
from halfphysics.viewer.controls import Controls
from halfphysics.viewer.dropped import Dropped
from halfphysics.viewer.framing import WINDOW, on_people
from halfphysics.viewer.layers import add_layers
from halfphysics.viewer.motions import as_result
from halfphysics.viewer.served import Served
from halfphysics.viewer.stage import Layer, Stage, aim, light
from halfphysics.viewer.theme import add_sky
from halfphysics.viewer.timeline import Timeline

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

#: Most results that are shown at once.
MOST = 6
# Name of the only result once another one is beside it.
_FIRST = "first"
# Browsers have this time to leave before the scene is taken apart [s].
_LEAVE = 3.0
# A file is shown although others are on their way, after this time [s].
_PATIENCE = 30.0
# Least time between updates [s]: allows 30 per second with some jitter.
_SPACING = 1.0 / 40.0
# Interval between checks for browsers and for `stop` [s].
_IDLE = 0.25
# Height of name labels above the head's joint [m].
_HEAD, _OVER = JOINT_INDEX["head"], 0.3


class Viewer(Served):
    """A running viewer, stopped by `stop` or at the end of a `with` block.

    Args:
        results: The results or motions to show side by side.
        labels: Names of the results; None: their numbers, with the stiffness if it differs.
        host: Address to listen on.
        port: Port to listen on; the next free one if it is in use.
        title: Title of the panel.

    Attributes:
        server: The viser server.
        stages: One stage per result.
        labels: Names of the results.
        timeline: The clock. It may be changed; then call `changed`.
        cameras: The cameras of the browsers.
    """

    _height = 560

    def __init__(
        self,
        results: Sequence[Result | Motion],
        *,
        labels: Sequence[str] | None = None,
        host: str = "127.0.0.1",
        port: int = 8080,
        title: str = "halfphysics",
    ) -> None:
        shown = [as_result(result, f"result {k + 1}") for k, result in enumerate(results)]
        self.labels = _labels(shown, labels)
        self._named = labels is not None
        self._what = f"showing {_and(self.labels)}"
        self._last = -math.inf  # time of the last update
        self._loads = 0  # how often the scene was built anew
        self._comparing: set[int] = set()  # browsers that show two halves
        self._dropped = Dropped()
        self._added: list[tuple[str, Drawing]] = []  # of files, to be shown with the next scene
        self._read = -math.inf  # when the last file was read
        super().__init__(title, host, port)
        with self._starting():
            self._set_up([Drawing(result) for result in shown])

    def _set_up(self, drawings: Sequence[Drawing]) -> None:
        """Build scene and panel of these results, with the present labels."""
        self.timeline = Timeline(*((len(d), d.result.fps) for d in drawings))
        room = _OVER if len(drawings) > 1 else 0.0
        row = arrange(drawings, WINDOW, headroom=room)
        self.stages = self._build(drawings, row)

        def home(window: tuple[int, int]) -> Camera:
            return on_people(self.cameras.people(), row.direction, window)

        self.references = [
            References(self.server, stage)
            for stage in self.stages
            if len(self.stages) == 1 and has_reference(stage.drawing)
        ]
        self.cameras = Cameras(self.server, self.stages, home, row.camera)
        self.cameras.following = True
        self.lights = light(self.server, row.direction.tolist(), row.reach)
        add_sky(self.server)
        aim(self.server, home(WINDOW))
        self.controls = Controls(self)
        self.controls.publish(self._root, self._loads)
        self.timeline.play()
        for stage in self.stages:
            stage.show(0)
        self.lights.follow(self.cameras.subject())

    def take(self, name: str, content: bytes) -> None:
        """Read a dropped file, to be shown; what is wrong with it is said in the page.

        By the viewer's own thread.
        """
        remote = self.controls.remote
        try:
            if len(self.stages) + len(self._added) >= MOST:
                raise InputError(f"{name}: {MOST} results are shown already, no more fit")
            remote.say(f"Reading {name} ...")
            self._added.append((Path(name).stem, self._dropped.read(name, content)))
        except HalfPhysicsError as error:
            remote.say(str(error))
        self._read = time.monotonic()

    def _show_added(self) -> None:
        """Show what was read beside what is shown, once no more is on its way.

        Browsers load the page anew: viser's cannot follow when a scene is taken apart.
        """
        uploads = None if self._root is None else self._root.uploads
        coming = uploads is not None and uploads.under_way
        if not self._added or (coming and time.monotonic() - self._read < _PATIENCE):
            return
        drawings = [*(stage.drawing for stage in self.stages), *(one for _, one in self._added)]
        first = self.labels if len(self.labels) > 1 or self._named else (_FIRST,)
        self.labels = (*first, *(name for name, _ in self._added))
        self._added.clear()
        remote = self.controls.remote
        self._loads += 1
        remote.tell(loads=self._loads)
        end = time.monotonic() + _LEAVE
        while self.server.get_clients() and time.monotonic() < end:
            time.sleep(0.01)
        self.server.scene.reset()
        self.server.gui.reset()
        self._set_up(drawings)

    def compare(self, client: int, on: bool) -> None:
        """A browser draws the references in one half of its picture, or no more.

        Their poses are sent while any browser does.
        """
        there = self._comparing & set(self.server.get_clients())
        self._comparing = there | {client} if on else there - {client}
        for references in self.references:
            references.switch(bool(self._comparing))

    def stop(self) -> None:
        """Stop serving; browsers lose the connection. Further calls have no effect."""
        super().stop()
        self._dropped.close()

    def _build(self, drawings: Sequence[Drawing], row: Any) -> list[Stage]:
        stages: list[Stage] = []
        floors: dict[float, Any] = {}
        for k, drawing in enumerate(drawings):
            levels = {n: floor_height(item) for n, item in drawing.statics.items()}
            # Results on one level share a floor: two floors in one place flicker.
            shared = {n for n, z in levels.items() if z is not None and round(z, 6) in floors}
            stage = Stage(
                self.server,
                drawing,
                f"/{k}" if len(drawings) > 1 else "",
                row.offsets[k],
                faint=row.faint[k],
                without=shared,
            )
            for name, height in levels.items():
                if height is not None and name not in shared:
                    floors[round(height, 6)] = stage.static(name.removeprefix("static/"))
            if len(drawings) > 1:
                self._name(stage, self.labels[k])
            add_layers(self.server, stage)
            stages.append(stage)
        reach = float(np.linalg.norm(row.offsets, axis=1).max())
        for floor in floors.values():
            floor.width += 2.0 * reach
            floor.height += 2.0 * reach
        return stages

    def _name(self, stage: Stage, text: str) -> None:
        """Add a label that follows the head of the first person."""
        person = stage.drawing.result.people[0]
        over = person.body.joints(person.motion)[:, _HEAD] + np.array([0.0, 0.0, _OVER])
        over = np.round(over, 3)
        label = self.server.scene.add_label(
            stage.path("label"), text, position=tuple(over[0]), anchor="bottom-center"
        )

        def follow(frame: int) -> None:
            label.position = over[frame]

        stage.followers.append(follow)
        stage.layers["label"] = Layer("Names", [label])

    def __repr__(self) -> str:
        return f"Viewer({', '.join(self.labels)}: {self._state})"

    def changed(self) -> None:
        """Update at once after a change of the timeline."""
        self._wake.set()

    def _due(self) -> float:
        next_one = self._last + _SPACING - time.monotonic()
        return max(min(self.timeline.until_next(), _IDLE), next_one, 0.0)

    def _round(self) -> None:
        self._do_tasks()
        self._show_added()
        # Without a browser time goes on, but nothing is sent.
        if self.server.get_clients() and self._update():
            self._last = time.monotonic()

    def _update(self) -> bool:
        frames = self.timeline.frames()
        late = [k for k, stage in enumerate(self.stages) if stage.frame != frames[k]]
        with self.server.atomic() if late else contextlib.nullcontext():
            for k in late:
                self.stages[k].show(frames[k])
            if late:
                self.lights.follow(self.cameras.subject())
        self.cameras.watch()
        self.cameras.follow()
        self.controls.refresh()
        return bool(late)


def view(
    result: Result | Motion,
    *more: Result | Motion,
    labels: Sequence[str] | None = None,
    host: str = "127.0.0.1",
    port: int = 8080,
    block: bool = True,
) -> Viewer:
    """Show results in a browser: body, ghost, objects and scene, with play, pause, scrub, compare.

    Prints the address. Needs no display: an SSH tunnel opens the address on another machine.

    Args:
        result: The result to show, or a `Motion`: on the default body, with a floor at z = 0.
        more: Further results or motions, shown beside the first and synchronously.
        labels: Names of the results.
        host: Address to listen on; "0.0.0.0": any machine that can reach this one can view.
        port: Port to listen on; the next free one if it is in use, with a message.
        block: Wait until Ctrl-C; False: return at once, as in a notebook.

    Returns:
        The running viewer with `url`, and `Viewer.stop`; a context manager.

    Raises:
        InputError: Neither a result nor a motion, an invalid host or port, or a wrong number of
            labels.
        FileError: No port is free.
        MissingDependencyError: viser cannot be imported.
        KeyboardInterrupt: Ctrl-C while blocking; the viewer has been stopped.
    """
    viewer = Viewer((result, *more), labels=labels, host=host, port=port)
    viewer.say(block)
    return viewer


def _and(names: Sequence[str]) -> str:
    return " and ".join(filter(None, ["; ".join(names[:-1]), names[-1]]))


def _labels(results: Sequence[Result], labels: Sequence[str] | None) -> tuple[str, ...]:
    if labels is not None:
        if len(labels) != len(results):
            raise InputError(f"labels: found {len(labels)}, expected {len(results)}, one a result")
        return tuple(map(str, labels))
    if len(results) == 1:
        return ("the result",)
    return tuple(f"result {k + 1}{note}" for k, note in enumerate(differences(results)))


def differences(results: Sequence[Result]) -> list[str]:
    """Suffixes that distinguish the results' names, such as ", stiffness 0.5"; may be empty."""
    values = [getattr(getattr(r, "settings", None), "stiffness", None) for r in results]
    numbers = [f"{v:g}" if isinstance(v, int | float) else None for v in values]
    if len(set(numbers)) == 1:
        return [""] * len(results)
    return ["" if n is None else f", stiffness {n}" for n in numbers]
