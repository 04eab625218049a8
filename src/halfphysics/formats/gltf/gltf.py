"""glTF 2.0: animated skeletons of Mixamo, Rokoko, Move.ai, HUMOTO, Blender, and of `hp.export`.

People are the skins of the file (without skins, its turning nodes), matched and retargeted as those
of BVH files are; a skeleton with the 55 names of SMPL-X, as `hp.export` writes it, is read
unchanged. Meshes that are no skin are what stands and what moves: `load_sequence` brings them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gltf.animation import SAMPLED, Animation, animations
from halfphysics.formats.gltf.container import MAGIC, Container
from halfphysics.formats.gltf.nodes import Nodes
from halfphysics.formats.gltf.props import floor_height, props
from halfphysics.formats.gltf.rig import Rig, animated, bare_rig, check_poses, rigs
from halfphysics.formats.motion_builder import own_name
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton
from halfphysics.formats.skeletons.skeleton_maps import match_joints, names_of_smplx
from halfphysics.formats.skeletons.skeleton_motion import retargeted, smplx_motion
from halfphysics.formats.skeletons.source_skeleton import NEEDED
from halfphysics.geometry.shapes import Plane
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "gltf"
_SUFFIX = ".gltf"
#: What a JSON file begins with, and what its head has if it is glTF.
_TEXT, _MARK = b"{", b'"asset"'
#: Files of PromptHMR, which have the shell of glTF around other things.
_NOT_OURS = ".mcs"
#: A last frame this part of a frame after the last key is there: times are in single precision.
_LAST = 0.02
#: Frames beyond these cannot even be counted; how many are read is bounded by `check_poses`.
_MOST_FRAMES = 10**15
#: Bones that differ by less than this from the default body's are its own [m].
_SAME_BONES = 1e-5


@dataclass(frozen=True, eq=False)
class _File:
    """An open file: its animations by name, and the people of each."""

    container: Container
    nodes: Nodes
    clips: dict[str, Animation]
    skinned: list[Rig]

    def people(self, animation: Animation) -> list[Rig]:
        """The people: skeletons with legs and arms; if there are none, all skeletons that move.

        Exporters leave out the keys of what does not move: a skin without any is a person who keeps
        still, unless other clips of the file move them.
        """
        others = [other for other in self.clips.values() if other is not animation]
        people = [
            rig
            for rig in self.skinned
            if self._is_person(rig)
            and (self.moves(rig, animation) or not any(self.moves(rig, o) for o in others))
        ]
        if people:
            return people
        found = self.skinned or bare_rig(self.nodes, animation)
        found = [rig for rig in found if self.moves(rig, animation)]
        return [rig for rig in found if self._is_person(rig)] or found

    def moves(self, rig: Rig, animation: Animation) -> bool:
        """Whether a clip has keys of a skeleton."""
        return bool({node for node, _ in animation.keys} & self._nodes(rig))

    def _nodes(self, rig: Rig) -> set[int]:
        """The nodes of a skeleton and those above it."""
        return {*rig.nodes, *self.nodes.above(rig.nodes[0])}

    def _is_person(self, rig: Rig) -> bool:
        names = [self.nodes.names[node] for node in rig.nodes]
        index = {node: k for k, node in enumerate(rig.nodes)}
        parents = [index.get(self.nodes.parents[node], -1) for node in rig.nodes]
        return set(NEEDED) <= match_joints(names, parents).keys()

    def times(
        self, where: str, people: list[Rig], animation: Animation, options: Options
    ) -> _Times:
        """The frames to read: from the first to the last key of these people, who hold still
        before and after their own; where none of them has keys, of the clip."""
        nodes = {node for rig in people for node in self._nodes(rig)}
        keyed = {node for node, _ in animation.keys}
        moving = nodes & keyed or keyed
        start, stop = animation.span(moving)
        rate = animation.rate(moving)
        if rate is None:
            rate = options.fps or SAMPLED
            warn(f"{where}: its keys are at no even rate: read at {rate:g} fps (fps=)")
        if not (stop - start) * rate < _MOST_FRAMES:
            raise FileError(
                f"{where}: found keys from {start:g} to {stop:g} s, expected fewer than "
                f"{_MOST_FRAMES:,} frames"
            )
        count = int(np.floor((stop - start) * rate + _LAST)) + 1
        kept = range(count)[options.frames]
        if len(kept) < 2:
            raise FileError(
                f"{where}: found {len(kept)} frames of {count} to read, expected at least 2: "
                "velocities need a next frame"
            )
        check_poses(self.nodes, len(kept), nodes)
        numbers = kept.start + kept.step * np.arange(len(kept))
        return _Times(start + numbers / rate, rate)


@dataclass(frozen=True, eq=False)
class _Times:
    """Times (T,) [s] of frames, and their rate."""

    seconds: Array
    fps: float


_KNOWN: WeakKeyDictionary[Source, _File] = WeakKeyDictionary()


def _sniff(source: Source) -> bool:
    suffix = source.path.suffix.lower()
    if source.head[: len(MAGIC)] != MAGIC:
        text = source.head.removeprefix(b"\xef\xbb\xbf").lstrip()
        if text[:1] != _TEXT or suffix == _NOT_OURS or not (suffix == _SUFFIX or _MARK in text):
            return False
    _file(source)
    return True


def _file(source: Source) -> _File:
    """The parts of a file.

    Raises:
        FileError: It is damaged, or has nothing that moves.
    """
    if source in _KNOWN:
        return _KNOWN[source]
    container = Container(source.path)
    nodes = Nodes(container)
    clips: dict[str, Animation] = {}
    for animation in animations(container, len(nodes.names)):
        clips[own_name(animation.name, clips)] = animation
    if not clips:
        raise FileError(
            f"{source.path}: a model without animation, expected an animated skeleton. Export it "
            "with its animation; a mesh for a scene is read by Scene.add_static"
        )
    found = _File(container, nodes, clips, rigs(container, nodes))
    _KNOWN[source] = found
    return found


def _names(source: Source) -> list[str]:
    return list(_file(source).clips)


def _where(source: Source, options: Options) -> str:
    several = len(_file(source).clips) > 1
    return f"{source.path}, clip {options.clip!r}" if several else str(source.path)


def _people(source: Source, options: Options) -> tuple[_File, Animation, list[Rig]]:
    file = _file(source)
    animation = file.clips[options.clip]
    people = file.people(animation)
    if not people:
        raise FileError(
            f"{_where(source, options)}: no skeleton moves in it, expected a person's. Export the "
            "skeleton with its animation"
        )
    return file, animation, people


def _load(source: Source, options: Options) -> Motion:
    file, animation, people = _people(source, options)
    moving = [rig for rig in people if file.moves(rig, animation)]
    read, where = (moving or people)[0], _where(source, options)
    if len(people) > 1:
        names = ", ".join(repr(rig.name) for rig in people)
        which = "the first" if read is people[0] else "the first who moves"
        warn(f"{where}: of {len(people)} people ({names}) {which} is read; load_sequence reads all")
    times = file.times(where, [read], animation, options)
    return _read(source, options, file, animation, read, times)[0]


def _read(
    source: Source, options: Options, file: _File, animation: Animation, rig: Rig, times: _Times
) -> tuple[Motion, Body | None, float]:
    """A person's motion, their body if it is SMPL-X's, and metres per unit of the file."""
    where = _where(source, options)
    joints = animated(file.nodes, rig, animation, times.seconds)
    if not names_of_smplx(joints.names):
        motion, found = retargeted(where, options, joints, times.fps, NAME)
        return motion, None, found.scale
    rest = _rest(joints)
    pelvis = joints.names.index(skeleton.JOINT_NAMES[0])
    own = smplx_motion(where, options, joints, times.fps, NAME, pelvis=rest[pelvis])
    unit, turn = own.unit, own.turn
    if unit is not None and unit != 1.0:
        warn(f"{where}: not in metres, by the legs: read with {unit:g} m per unit")
    scale = unit or 1.0  # whose legs are nobody's has no body, which says it
    rest = scale * rest[[joints.names.index(name) for name in skeleton.JOINT_NAMES]]
    if turn is not None:
        rest = rot.rotate(rot.conjugate(turn), rest)
    return own.motion, _body(where, rest), scale


def _rest(joints: AnimatedSkeleton) -> Array:
    """Places of the joints at the bind pose (J, 3)."""
    rest = joints.offsets.copy()
    for joint, parent in enumerate(joints.parents):
        if parent >= 0:
            rest[joint] += rest[parent]
    return rest


def _body(where: str, rest: Array) -> Body | None:
    """The default body with the bones of the file; None: these are its own."""
    bones = rest.copy()
    bones[1:] -= rest[skeleton.PARENTS[1:]]
    own = np.asarray(Body.default().rest_joints)
    if np.abs(rest - own).max() < _SAME_BONES:
        return None
    with of_file(where):
        return Body.default(bones=bones)


def _load_sequence(source: Source, options: Options) -> Sequence:
    file, animation, people = _people(source, options)
    where = _where(source, options)
    times = file.times(where, people, animation, options)
    read = [_read(source, options, file, animation, rig, times) for rig in people]
    motions, scale = [motion for motion, _, _ in read], read[0][2]
    bodies = tuple(Body.default() if body is None else body for _, body, _ in read)
    scene, tracks = _scene(
        file, animation, people, times.seconds, motions[0], scale, where, options
    )
    if len(motions) == 1:
        return Sequence(motions[0], scene, read[0][1], recorded=tracks)
    return Sequence(tuple(motions), scene, bodies, recorded=tracks)


def _scene(
    file: _File,
    animation: Animation,
    people: list[Rig],
    times: Array,
    motion: Motion,
    scale: float,
    where: str,
    options: Options,
) -> tuple[Scene, dict[str, ObjectTrack]]:
    """What stands and what moves around the people, and the record of the latter."""
    scene, tracks, axes = Scene(), {}, motion.axes
    scale, options = scale * options.unit, replace(options, unit=1.0)
    joints = [node for rig in people for node in rig.nodes]
    for prop in props(file.container, file.nodes, animation, joints, times):
        mesh = type(prop.mesh)(prop.mesh.vertices * scale, prop.mesh.faces)
        places = scale * prop.positions
        sized = prop._replace(mesh=mesh, positions=places)
        with of_file(where):
            height = floor_height(sized, axes[2])
            if height is not None:
                scene.add_static(prop.name, Plane(offset=height))
            elif prop.moves and prop.whole and options.objects == "free":
                warn(
                    f"{where}: what joins the parts of {prop.whole!r} is not known: they move as "
                    "recorded"
                )
                position = places @ axes.T
                quaternion = rot.from_matrix(axes @ prop.rotations)
                scene.add_moving(prop.name, mesh, position, quaternion, fps=motion.fps, up="z")
                tracks[prop.name] = ObjectTrack(position=position, quaternion=quaternion)
            elif prop.moves:
                tracks[prop.name] = add_recorded(
                    scene, prop.name, mesh, places, prop.rotations,
                    where=where, axes=axes, fps=motion.fps, options=options,
                )  # fmt: skip
            else:
                scene.add_static(
                    prop.name, mesh, position=axes @ places[0],
                    quaternion=rot.from_matrix(axes @ prop.rotations[0]),
                )  # fmt: skip
    return scene, tracks


FORMAT = Format(
    name=NAME,
    about="animated skeletons of HUMOTO, Mixamo, Rokoko, Move.ai, Blender and halfphysics itself",
    invents="the person's shape, gender and model",
    expects="glTF 2.0 (.glb, .gltf) with an animation of a person's skeleton",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_names,
)
