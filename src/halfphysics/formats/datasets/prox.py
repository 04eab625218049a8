"""PROX: a person in a scanned room before a Kinect; SMPL-X, 30 fps.

`PROXD/RECORDING/results/` has a folder for each frame ("s001_frame_00001__00.00.00.029") with
`000.pkl`: `smplx` parameters of one frame, `global_orient, transl (1, 3)`, `body_pose (1, 63)`,
`left_hand_pose, right_hand_pose (1, 12)` about the relaxed hand, `betas (1, 10)`, and
`camera_rotation`, `camera_translation`, `pose_embedding`. All is in the frame of the camera;
`cam2world/SCENE.json` is its 4 x 4 matrix in the world of the scan, z-up, and `scenes/SCENE.ply`
the scan. A recording is named SCENE_SUBJECT_NUMBER; it, or `results` in it, is loaded.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import shape_of
from halfphysics.formats.datasets.assets import find, seek
from halfphysics.formats.datasets.frame_folders import a_frame, people_in, person_in
from halfphysics.formats.datasets.recorded import of_file
from halfphysics.formats.datasets.rigid_place import read_json, rigid
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "prox"
FPS = 30.0
RESULTS = "results"
_WOMEN = frozenset({159, 162, 3403, 3452})
_KEYS = {"camera_translation", "camera_rotation", "pose_embedding"}


def _sniff(source: Source) -> bool:
    if not source.is_folder:
        return False
    data = a_frame(_results(source))
    return data is not None and bool(data.keys() & _KEYS)


def _results(source: Source) -> Path:
    inside = source.path / RESULTS
    return inside if inside.is_dir() else source.path


def _recording(source: Source) -> tuple[str, str]:
    """Names of the scene and of the subject."""
    folder = source.path.resolve()
    words = (folder.parent if folder.name == RESULTS else folder).name.split("_")
    return words[0], words[1] if len(words) > 1 else ""


def _world(source: Source, options: Options) -> tuple[Array, Array] | None:
    """Rotation and place of the camera in the world; None: the table is not there."""
    file = f"{_recording(source)[0]}.json"
    path = seek(source, options, [f"cam2world/{file}"])
    if path is None:
        return None
    matrix = read_json(path)
    if shape_of(matrix) != (4, 4):
        raise FileError(f"{path}: found no matrix (4, 4), expected the camera in the world")
    rows = np.asarray(matrix)
    return rigid(path, rows[:3, :3], rows[:3, 3])


def _load(source: Source, options: Options) -> Motion:
    folder = _results(source)
    track = people_in(folder)[0]
    subject = _recording(source)[1]
    gender = None
    if subject.isdecimal():
        gender = "female" if int(subject) in _WOMEN else "male"
    where = str(source.path)
    person = person_in(where, folder, track, options, options.gender or gender or "neutral")
    world = _world(source, options)
    if world is None:
        warn(
            f"{where}: in the frame of the camera, which may be tilted: cam2world/"
            f"{_recording(source)[0]}.json of the data set is not there (assets=)"
        )
    return motion_of(
        where,
        options,
        format=NAME,
        translation=person.translation,
        rotations=person.rotations,
        fps=FPS,
        up="-y" if world is None else "z",
        model="smplx",
        gender=gender,
        betas=person.betas,
        hands=person.hands,
        world=world,
    )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    name = _recording(source)[0]
    if _world(source, options) is None:
        raise FileError(
            f"{source.path}: where its camera is in the scan is in cam2world/{name}.json, which is "
            "not there. Name the data set's folder with assets=, or read the motion alone with "
            "Motion.load"
        )
    path = find(source, options, [f"scenes/{name}.ply"], f"the scan of {name!r}")
    scene = Scene()
    with of_file(str(path)):
        turn = rot.from_matrix(axes_of(options.up or "z"))
        scene.add_static(name, path, quaternion=turn, up="z")
    return Sequence(motion, scene)


FORMAT = Format(
    name=NAME,
    about="PROX: a person in a scanned room",
    invents="fingers (components, without the model), the frame rate (30)",
    expects="a folder with results/FRAME/000.pkl: global_orient, body_pose, camera_translation",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
