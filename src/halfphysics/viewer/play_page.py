"""One HTML file with physics: the core runs in the browser, from disk, with no server."""

from __future__ import annotations

import os
from collections.abc import Sequence as Several
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.errors import InputError
from halfphysics.render.result_meshes import Drawing
from halfphysics.simulation.simulator import Simulator
from halfphysics.viewer.arrange import Arrangement, arrange
from halfphysics.viewer.coloring import RAMP
from halfphysics.viewer.contacts import ContactNodes, FrameContacts, Ints
from halfphysics.viewer.core_files import compiled_world, core_program, core_script
from halfphysics.viewer.page import assembled, quiet_server
from halfphysics.viewer.page_data import camera_data, layer_data
from halfphysics.viewer.page_key import key
from halfphysics.viewer.play_data import kinds_there, play_data
from halfphysics.viewer.player_script import play_head
from halfphysics.viewer.provisional import provisional
from halfphysics.viewer.session import bodies_of
from halfphysics.viewer.stage import Stage, aim, light, middle
from halfphysics.viewer.whereabouts import goes_far, track

if TYPE_CHECKING:
    from halfphysics.simulation.sequence import Sequence

_VIEW = (1280, 720)
# Nothing moves before the page is open: the camera's track is that of the first frame.
_FIRST = range(1)


@dataclass
class NoContacts:
    """Contacts of a page before its simulation starts.

    Attributes:
        kind: The kinds that can occur.
    """

    kind: Ints

    def at(self, frame: int) -> FrameContacts:
        """None."""
        return FrameContacts(
            rows=np.zeros(0, dtype=np.int64),
            kind=np.zeros(0, dtype=np.int64),
            position=np.zeros((0, 3)),
            force=np.zeros((0, 3)),
        )


def save_play_page(
    sequence: Sequence,
    path: str | os.PathLike[str],
    *,
    title: str = "halfphysics",
    notes: Several[str] = (),
) -> Path:
    """Write a self-contained HTML page in which physics runs.

    The page has the core in WebAssembly, the compiled world and the reference motion. In it one
    drags objects, and sets their mass and friction and the stiffness of the people. Without that,
    its numbers are those of `simulate`. It also contains the skin of each person's body and the
    body's parts: share the page of a licensed body model only as its licence allows.

    Args:
        sequence: Motions, scene, bodies and settings.
        path: The file to write; written completely or not at all.
        title: Title of the page.
        notes: Lines of text below the title.

    Returns:
        The path written.

    Raises:
        InputError: Nobody moves, or people of different frame rates or lengths.
        FileError: The file cannot be written, or no local port can be opened.
        MissingDependencyError: viser is not installed.
    """
    from halfphysics.base.atomic import atomic_write

    motions = sequence.motions
    if not motions or len({(len(m), m.fps) for m in motions}) > 1:
        shown = ", ".join(f"{len(m)} frames at {m.fps:g} fps" for m in motions) or "no motion"
        raise InputError(f"page: found {shown}, expected motions of one length and frame rate")
    simulator = Simulator(
        sequence.scene, body=bodies_of(sequence), settings=sequence.settings, fps=motions[0].fps
    )
    frame = simulator.reset([motion[0] for motion in motions])
    drawing = Drawing(provisional(simulator, motions, frame.objects))
    row = arrange([drawing], _VIEW)
    with atomic_write(path) as file, quiet_server() as server:
        stage, contacts, scene = _scene(server, drawing, row, simulator)
        data = {
            **camera_data([stage], row, _FIRST),
            "follow": goes_far(track([drawing], row.offsets, range(len(drawing)))),
            "title": title,
            "fps": motions[0].fps,
            "ramp": [list(color) for color in RAMP],
            "people": [figure.name for figure in stage.people],
            "layers": _layers(stage),
            "key": key([drawing], list(contacts.points), notes=notes),
            "dropText": "A page with physics takes no files.",
            "play": {
                **play_data(simulator, motions, stage, contacts),
                "wasm": core_program(),
                "world": compiled_world(simulator, motions),
            },
        }
        page = assembled(scene, play_head(data, core_script()), title, [drawing], row)
        file.write(page.encode("utf-8"))
    return Path(path)


def _scene(
    server: Any, drawing: Drawing, row: Arrangement, simulator: Simulator
) -> tuple[Stage, ContactNodes, str]:
    """The stage and the contacts of the page, and viser's page of them at the first frame."""
    aim(server, row.first(_VIEW, panel=False))
    stage = Stage(server, drawing, faint=row.faint[0], live=True)
    contacts = ContactNodes(server, stage, NoContacts(kinds_there(simulator)))
    lights = light(server, row.direction.tolist(), row.reach)
    stage.show(0)
    lights.follow(middle([stage]))
    return stage, contacts, server.get_scene_serializer().as_html()


def _layers(stage: Stage) -> list[dict[str, Any]]:
    """As of a recorded page; contacts come while it runs."""
    return [
        *layer_data([stage], support=False),
        {"id": "skin", "label": "Skin by force", "on": True, "nodes": []},
        {"id": "arrows", "label": "Force arrows", "on": True, "nodes": ["/contact/arrow"]},
        {"id": "points", "label": "Contact points", "on": True, "nodes": ["/contact/point"]},
    ]
