"""What the script of a page with physics reads: who is there, what moves, what it is driven to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.skeleton import (
    JOINT_INDEX,
    LEFT_HAND_JOINTS,
    N_JOINTS,
    PARENTS,
    RIGHT_HAND_JOINTS,
)
from halfphysics.render.ghost import PARTS, Separation
from halfphysics.render.look import GHOST_ALPHA
from halfphysics.simulation.dragging import draggable
from halfphysics.viewer.contacts import KINDS, PERSON, ContactNodes
from halfphysics.viewer.figure import Figure, rgb
from halfphysics.viewer.lights import SUBJECT
from halfphysics.viewer.marks import kind_label
from halfphysics.viewer.packing import packed

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.simulator import Simulator
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]


def play_data(
    simulator: Simulator, motions: Sequence[Motion], stage: Stage, contacts: ContactNodes
) -> dict[str, Any]:
    """The document of a page's simulation.

    Args:
        simulator: The simulator, of whose world the page gets the compiled file.
        motions: The reference of each person.
        stage: The stage of the page, live.
        contacts: The nodes of its contacts.
    """
    world, shown = simulator.world, simulator.settings.stiffness
    return {
        "fps": motions[0].fps,
        "frames": len(motions[0]),
        "gravity": np.asarray(world.scene.gravity).tolist(),
        "parents": np.asarray(PARENTS).tolist(),
        "hips": [JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]],
        "hands": [
            *(JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS),
            *(JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS),
        ],
        "ghostAlpha": GHOST_ALPHA,
        "subject": SUBJECT,
        "kinds": [_kind(kind, contacts) for kind in contacts.points],
        "people": [_person(stage, k, motion) for k, motion in enumerate(motions)],
        "objects": [_object(stage, simulator, name) for name in stage.drawing.objects],
        "statics": len(world.scene.statics),
        "persons": len(world.names) - len(world.people),
        "stiffness": np.asarray(world.stiffness).tolist(),
        "stiffnessUnit": stiffness_array(1.0, "stiffness").tolist(),
        "stiffnessShown": float(shown) if isinstance(shown, int | float) else 1.0,
        "translations": packed(np.stack([m.translation for m in motions], axis=1), "<f8"),
        "rotations": packed(np.stack([m.rotations for m in motions], axis=1), "<f8"),
    }


def kinds_there(simulator: Simulator) -> NDArray[np.int64]:
    """The kinds of contacts that can occur, indices into `KINDS`."""
    alone = len(simulator.bodies) == 1
    return np.array([k for k in range(len(KINDS)) if not (alone and k == PERSON)])


def _kind(kind: int, contacts: ContactNodes) -> dict[str, Any]:
    return {
        "kind": kind,
        "label": kind_label(kind),
        "color": "rgb({},{},{})".format(*rgb(KINDS[kind].color)),
        "point": contacts.points[kind].handle.name,
        "arrow": contacts.arrows[kind].handle.name,
    }


def _person(stage: Stage, k: int, motion: Motion) -> dict[str, Any]:
    """A person: rest joints, and which joints move which piece of the skin."""
    body = stage.people[k].body
    rest = np.asarray(body.rest_joints)
    ghost = [{**piece, "of": PARTS[name]} for name, piece in _pieces(stage.ghosts[k]).items()]
    return {
        "rest": rest.tolist(),
        "pelvis": (np.asarray(motion.axes) @ rest[0]).tolist(),
        "tips": np.round(Separation(body).tips, 5).tolist(),
        "pieces": list(_pieces(stage.people[k]).values()),
        "ghost": ghost,
    }


def _pieces(figure: Figure) -> dict[str, dict[str, Any]]:
    return {
        name: {"node": handle.name, "joints": figure.joints[figure.bones_of(name)].tolist()}
        for name, handle in figure.handles.items()
    }


def _object(stage: Stage, simulator: Simulator, path: str) -> dict[str, Any]:
    """An object or a link: its body in the core, and what can be turned."""
    name, world = path.removeprefix("object/"), simulator.world
    # The core counts the parts of people first, then what else is tracked (src/native/capi).
    number = [place.name for place in world.tracked].index(name)
    found: dict[str, Any] = {
        "name": name,
        "node": stage.path(path),
        "body": N_JOINTS * len(world.people) + number,
        "free": draggable(simulator, name),
    }
    if found["free"]:
        item = world.scene.objects[name]
        found |= {"mass": float(item.mass), "friction": float(item.friction)}
    return found
