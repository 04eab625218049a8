"""RICH: people in scanned places, several cameras; SMPL-X, 30 fps.

`bodies/SET/SCENE_SUBJECT_NAME/` has a folder for each frame ("00017"), in it for each person a
pickle ("005.pkl") of `smplx` parameters: `global_orient, transl (1, 3)`, `body_pose (1, 63)`,
`left_hand_pose, right_hand_pose (1, 12)` about the relaxed hand, `betas (1, 10)`, face. All is in
the frame of the first camera; `multicam2world/SCENE_multicam2world.json` has `R, c, t` with world
rows ``c v R + t``, and `scan_calibration/SCENE/scan_camcoord.ply` is the scan in the cameras'
frame. The world here has its size: it is divided by c.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.datasets.assets import find, seek
from halfphysics.formats.datasets.frame_folders import a_frame, people_in, person_in
from halfphysics.formats.datasets.recorded import of_file
from halfphysics.formats.datasets.rigid_place import read_json, rigid
from halfphysics.formats.datasets.standing_axis import Up, standing_axis
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of
from halfphysics.formats.people import Track
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

NAME = "rich"
FPS = 30.0
_WOMEN = frozenset({9, 10, 12, 13, 16, 17, 18, 19, 21})
#: What only the pickles of PROX have.
_OF_PROX = {"camera_translation", "camera_rotation", "pose_embedding"}


def _sniff(source: Source) -> bool:
    if not source.is_folder:
        return False
    data = a_frame(source.path)
    return data is not None and not data.keys() & _OF_PROX


def _people(source: Source) -> list[Track]:
    return people_in(source.path)


def _scene_name(source: Source) -> str:
    return source.path.resolve().name.split("_")[0]


def _world(source: Source, options: Options) -> tuple[Array, Array] | None:
    """Rotation and place of the cameras' frame in the world; None: the table is not there."""
    file = f"{_scene_name(source)}_multicam2world.json"
    path = seek(source, options, [f"multicam2world/{file}", file])
    if path is None:
        return None
    said = read_json(path)
    if not isinstance(said, dict) or not {"R", "t"} <= said.keys():
        raise FileError(f"{path}: expected R (3, 3), c and t (3,)")
    turn, place = rigid(path, said["R"], said["t"])
    size = said.get("c", 1.0)
    if not isinstance(size, int | float) or not 0.0 < size < np.inf:
        raise FileError(f"{path}: 'c': found {size!r}, expected a number above 0")
    return turn.T, place / float(size)


def _load(source: Source, options: Options) -> Motion:
    track = next(track for track in _people(source) if track.name == options.clip)
    subject = int(track.name) if track.name.isdecimal() else None
    gender = None if subject is None else "female" if subject in _WOMEN else "male"
    where = f"{source.path}, clip {track.name!r}"
    person = person_in(where, source.path, track, options, options.gender or gender or "neutral")
    world = _world(source, options)
    return motion_of(
        where,
        options,
        format=NAME,
        translation=person.translation,
        rotations=person.rotations,
        fps=FPS,
        up=_up(where, source, options, person.rotations, world),
        model="smplx",
        gender=gender,
        betas=person.betas,
        hands=person.hands,
        world=world,
    )


def _up(
    where: str,
    source: Source,
    options: Options,
    rotations: Array,
    world: tuple[Array, Array] | None,
) -> Up:
    if world is None:
        warn(
            f"{where}: in the frame of the first camera, which may be tilted: "
            f"{_scene_name(source)}_multicam2world.json of the data set is not there (assets=)"
        )
        return standing_axis(
            where, rotations, options, rule="-y", others=("y", "z"), of="a camera of RICH"
        )
    root = rot.log(rot.multiply(rot.from_matrix(world[0]), rot.exp(rotations[:, 0])))
    return standing_axis(where, root, options, rule="z", others=("y", "-y"), of="the world of RICH")


def _scene(source: Source, options: Options) -> Scene:
    """The scan, where the people are put."""
    scene, name = Scene(), _scene_name(source)
    file = f"scan_calibration/{name}/scan_camcoord.ply"
    path: Path = find(source, options, [file, f"{name}/scan_camcoord.ply"], f"the scan of {name!r}")
    world = _world(source, options)
    turn, place = (np.eye(3), np.zeros(3)) if world is None else world
    longest = max(_people(source), key=len)
    whole, where = replace(options, frames=slice(None), hands="flat"), str(source.path)
    person = person_in(where, source.path, longest, whole, "neutral")
    axes = axes_of(options.up or _up(where, source, options, person.rotations, world))
    with of_file(str(path)):
        scene.add_static(
            name,
            path,
            position=axes @ place,
            quaternion=rot.from_matrix(axes @ turn),
            up="z",
        )
    return scene


FORMAT = Format(
    name=NAME,
    about="RICH: people in scanned places",
    invents="fingers (components, without the model), the up axis, the frame rate (30)",
    expects="a folder with a folder for each frame, and in it a pickle for each person of "
    "global_orient, body_pose, transl",
    sniff=_sniff,
    load=_load,
    people=_people,
    scene=_scene,
)
