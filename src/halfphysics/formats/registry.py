"""The registry of motion formats. A new format is one module of this package and one line below."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from collections.abc import Sequence as Listing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

from halfphysics.base.reader_warnings import one_warning, warn
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.errors import FileError, InputError
from halfphysics.formats import blender, edge, emage, hymotion, plain, smpl_codec
from halfphysics.formats.amass import fields as amass
from halfphysics.formats.amass import smpl as amass_smpl
from halfphysics.formats.amass import smplh as amass_smplh
from halfphysics.formats.amass import smplx as amass_smplx
from halfphysics.formats.bvh import bvh
from halfphysics.formats.checked_fields import shape_of
from halfphysics.formats.checked_options import checked_options
from halfphysics.formats.content_check import checked
from halfphysics.formats.datasets import (
    aist,
    arctic,
    behave,
    core4d,
    emdb,
    grab,
    habitat,
    humanclaw,
    interact,
    intercap,
    interhuman,
    intermimic,
    interx,
    motionx,
    omomo,
    parahome,
    prox,
    rich,
    threedpw,
    trumans_clip,
    trumans_release,
)
from halfphysics.formats.datasets.ground import add_ground, needs_ground
from halfphysics.formats.floor import motion_on_floor, on_floor
from halfphysics.formats.format import Assets, Format, Options, Source
from halfphysics.formats.frame_range import in_range
from halfphysics.formats.gltf import gltf
from halfphysics.formats.people import Track, chosen, together
from halfphysics.formats.positions import humanml, joint_array, kimodo, mdm, mdm_smpl
from halfphysics.formats.results.motion_of_result import of_result
from halfphysics.formats.video import (
    bedlam,
    comotion,
    gemx,
    gvhmr,
    mcs,
    phalp,
    prompthmr,
    romp,
    sam3d,
    slahmr,
    smplerx,
    tram,
    wham,
)
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.simulation.sequence import Sequence

logger = logging.getLogger(__name__)

T = TypeVar("T")

__all__ = [
    "FORMATS",
    "Format",
    "Options",
    "Source",
    "identify",
    "load_motion",
    "load_sequence",
    "unknown",
]

#: Every motion format, tried in this order.
FORMATS: dict[str, Format] = {
    format.name: format
    for format in (
        slahmr.FORMAT,  # before AMASS, which has fields of the same names
        behave.FORMAT,  # before AMASS, which has fields of the same names and another axis up
        core4d.FORMAT,
        emage.FORMAT,  # before AMASS, too
        hymotion.FORMAT,  # before AMASS, too
        interact.FORMAT,
        interx.FORMAT,
        humanclaw.FORMAT,
        amass_smplx.FORMAT,
        amass_smplh.FORMAT,
        amass_smpl.FORMAT,
        aist.FORMAT,
        edge.FORMAT,  # AIST++'s names without its scaling
        grab.FORMAT,
        motionx.FORMAT,
        arctic.FORMAT,
        smpl_codec.FORMAT,
        intercap.FORMAT,  # before plain dicts of the smplx package, whose names these have, too
        parahome.FORMAT,
        interhuman.FORMAT,
        emdb.FORMAT,
        threedpw.FORMAT,
        prox.FORMAT,
        rich.FORMAT,
        gvhmr.FORMAT,
        gemx.FORMAT,
        wham.FORMAT,
        prompthmr.FORMAT,
        mcs.FORMAT,
        tram.FORMAT,
        phalp.FORMAT,
        comotion.FORMAT,
        romp.FORMAT,
        smplerx.FORMAT,
        bedlam.FORMAT,
        habitat.FORMAT,
        trumans_clip.FORMAT,
        plain.FORMAT,  # after the data sets whose files have these names, too
        trumans_release.FORMAT,
        omomo.FORMAT,
        intermimic.FORMAT,
        mdm.FORMAT,
        mdm_smpl.FORMAT,
        humanml.FORMAT,
        joint_array.FORMAT,
        kimodo.FORMAT,
        blender.FORMAT,
        bvh.FORMAT,
        gltf.FORMAT,
        sam3d.FORMAT,  # last: it looks into pickles of any kind
    )
}

#: Names of the rotations of all joints in one row a frame: AMASS's, then those of MoSh and others.
_POSES = ("poses", "fullpose", "full_pose", "pose")
#: What binary files of FBX begin with, and files of USD, and how the latter end.
_FBX = b"Kaydara FBX Binary"
_USD, _USD_SUFFIXES = (b"PXR-USDC", b"#usda"), (".usd", ".usda", ".usdc", ".usdz")


def identify(source: Source) -> Format | None:
    """The format of a file, with the people of a result; None: no known format."""
    for format in FORMATS.values():
        if format.sniff is not None and format.sniff(source):
            return of_result(source, format)
    return None


def load_motion(
    path: str | os.PathLike[str],
    *,
    fps: float | None = None,
    up: str | None = None,
    hands: str | None = None,
    model: str | os.PathLike[str] | None = None,
    gender: str | None = None,
    frames: tuple[int | None, int | None] | None = None,
    clip: str | None = None,
    assets: Assets = None,
    floor: float | Literal["lowest"] | None = None,
) -> Motion:
    """Implements `Motion.load`; see there."""
    clock = Stopwatch(logger)
    options = checked_options(fps, up, hands, model, gender, frames, clip, assets, floor=floor)
    source, format, options = _found(path, options)
    if format.people is not None:
        track = chosen(str(source.path), format.people(source), options.clip)
        options = replace(options, clip=track.name)
    if _is_result(source):
        motion = format.load(source, options)
    else:
        motion = checked(
            str(source.path),
            options,
            lambda given: in_range(
                str(source.path), given, lambda some: format.load(source, some), len
            ),
            people=lambda found: (found,),
            explained=lambda found: False,
        )
    if options.floor is not None:
        motion = motion_on_floor(motion, options.floor)
    clock.done("loaded %s: %r", source.path, motion)
    return motion


def load_sequence(
    path: str | os.PathLike[str],
    assets: Assets = None,
    *,
    objects: str = "free",
    adapt: bool = True,
    grip: bool = True,
    ground: bool = True,
    fps: float | None = None,
    up: str | None = None,
    hands: str | None = None,
    model: str | os.PathLike[str] | None = None,
    gender: str | None = None,
    frames: tuple[int | None, int | None] | None = None,
    clip: str | None = None,
    floor: float | Literal["lowest"] | None = None,
) -> Sequence:
    """Read a motion with the objects and the scene that its data set recorded.

    Where a file tracks several people, those who are there together are read, over the frames that
    they share; `clip` names one of them.

    Args:
        path: As in `Motion.load`, with the options there.
        assets: Folders of the data set's other files (object meshes, templates), searched before
            $HALFPHYSICS_MODELS, the file's folder and the folders above it.
        objects: "free": dynamic, from their recorded poses at the first frame;
            "replayed": kinematic along the recorded trajectory. `Sequence.recorded` has the
            recorded trajectory in both cases.
        adapt: Where recorded hands hold a free object they are brought onto it and press
            (`halfphysics.adapt`; `Motion.recorded` is the motion as recorded, `Motion.holds` what
            is held). False: the motion stays as it is.
        grip: With `adapt`: hands press with what the load needs. False: they touch.
        ground: Where the data set brings free objects and nothing to stand on, they get a floor
            named "ground", at the height of the lowest skin and of the lowest of the objects.
            False: none, and all falls.
        floor: As in `Motion.load`; the things and the scene move along. The lowest skin is that of
            the people's own bodies where the data set says them.

    Returns:
        A `Sequence`; for a format without objects, the motion with an empty scene.

    Warns:
        HalfPhysicsWarning: All that was assumed and adapted, in one line.

    Raises:
        FileError, InputError: As `Motion.load`, and if an asset is missing.
    """
    clock = Stopwatch(logger)
    if objects not in ("free", "replayed"):
        raise InputError(f"objects: found {shown(objects)}, expected 'free' or 'replayed'")
    options = checked_options(fps, up, hands, model, gender, frames, clip, assets, objects, floor)
    source, format, options = _found(path, options)
    with one_warning(source.path):
        if _is_result(source):
            sequence = _sequence(source, format, options)
        else:
            sequence = checked(
                str(source.path),
                options,
                lambda given: in_range(
                    str(source.path),
                    given,
                    lambda some: _sequence(source, format, some),
                    lambda found: len(found.motions[0]),
                ),
                people=lambda found: found.motions,
                explained=lambda found: bool(found.scene.statics or (ground and found.recorded)),
            )
        if options.floor is not None:
            sequence = on_floor(sequence, options.floor)
        if objects == "free" and sequence.recorded:
            if ground and needs_ground(sequence):
                add_ground(sequence, source.path, None if options.floor is None else 0.0)
            if adapt:
                sequence = adapted(sequence, source.path, grip=grip)
    clock.done("loaded %s: %r", source.path, sequence)
    return sequence


def _is_result(source: Source) -> bool:
    """Whether a file holds a result, whose motion was looked at when its input was read."""
    return source.npz is not None and any("/" in key for key in source.npz)


def _sequence(source: Source, format: Format, options: Options) -> Sequence:
    """Motion and scene of a file as its format has them."""
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

    if format.people is not None:
        motions, bodies = _people(source, format.people(source), format, options)
        scene = format.scene(source, options) if format.scene else Scene()
        return Sequence(_one_or_all(motions), scene, _one_or_all(bodies) if bodies else None)
    if format.load_sequence is None:
        return Sequence(format.load(source, options), Scene())
    return format.load_sequence(source, options)


def _one_or_all(items: tuple[T, ...]) -> T | tuple[T, ...]:
    return items if len(items) > 1 else items[0]


def _people(
    source: Source, tracks: Listing[Track], format: Format, options: Options
) -> tuple[tuple[Motion, ...], tuple[Body, ...]]:
    """The person whom `clip` names, or those of a file who are there together; and their bodies,
    none if the format has none."""
    where = str(source.path)
    if options.clip:
        kept, parts = [chosen(where, tracks, options.clip)], [options.frames]
    else:
        kept, start, stop = together(where, tracks)
        first, last, step = options.frames.indices(stop - start)
        begins = [start - track.start for track in kept]
        parts = [slice(begin + first, begin + last, step) for begin in begins]
    own = [
        replace(options, clip=track.name, frames=part)
        for track, part in zip(kept, parts, strict=True)
    ]
    if format.load_person is None:
        return tuple(format.load(source, each) for each in own), ()
    found = [format.load_person(source, each) for each in own]
    return tuple(motion for motion, _ in found), tuple(body for _, body in found)


def adapted(sequence: Sequence, path: Path, *, grip: bool = True) -> Sequence:
    """`Sequence.adapted`, and a warning that says what was adapted in the motion of a file."""
    from halfphysics.adaptation.adapt import Adaptation

    sequence = sequence.adapted(grip=grip)
    told = [Adaptation(motion).summary() for motion in sequence.motions if motion.holds]
    if told:
        warn(f"{path}: {'; '.join(told)}")
    return sequence


def _found(path: str | os.PathLike[str], options: Options) -> tuple[Source, Format, Options]:
    """The file, its format, and the options with the name of the clip."""
    from itertools import islice

    source = path if isinstance(path, Source) else Source(path)
    format = identify(source)
    if format is None:
        raise unknown(source)
    if format.people is not None:
        return source, format, options
    if format.clips is None:
        if options.clip:
            raise InputError(
                f"clip: found {options.clip!r}, but {source.path} holds one motion only. Leave it "
                "out"
            )
        return source, format, options
    if not options.clip:
        names = list(islice(format.clips(source), 13))
        if not names:
            raise no_clips(source)
        if len(names) == 1:
            return source, format, replace(options, clip=names[0])
        more = ", ..." if len(names) > 12 else ""
        raise InputError(
            f"{source.path}: holds several clips: {', '.join(names[:12])}{more}. Say which with "
            "clip=; halfphysics.clips(path) goes through them all"
        )
    names = list(format.clips(source))
    if not names:
        raise no_clips(source)
    if options.clip not in names:
        hint = did_you_mean(options.clip, names, count=3, otherwise=f", such as {names[0]!r}")
        raise InputError(
            f"clip: {source.path} has no {options.clip!r}, expected one of its {len(names)} clips"
            f"{hint}"
        )
    return source, format, options


def no_clips(source: Source) -> FileError:
    """The error for a file of clips that has none."""
    return FileError(f"{source.path}: holds no clips, expected at least one")


def unknown(source: Source) -> FileError:
    """The error for a file of no known format."""
    npz = source.npz
    if npz is not None and {"v_template", "J_regressor"} & set(npz):
        return FileError(
            f"{source.path}: this is a body model, expected a motion. Load it with Body.load"
        )
    if source.head.startswith(_FBX) or source.path.suffix.lower() == ".fbx":
        return FileError(
            f"{source.path}: this is an FBX file, whose layout is not published, expected an open "
            "one. Convert it, for example in Blender: File > Import > FBX, then File > Export > "
            "glTF 2.0 with its animation"
        )
    if source.head.startswith(_USD) or source.path.suffix.lower() in _USD_SUFFIXES:
        return FileError(
            f"{source.path}: this is a USD file, which is written but not read, expected a motion. "
            "Convert it, for example in Blender: File > Import > Universal Scene Description, then "
            "File > Export > glTF 2.0 with its animation"
        )
    known = "; ".join(
        f"{format.name}: {format.expects}" for format in FORMATS.values() if format.sniff
    )
    if source.is_folder:
        return FileError(
            f"{source.path}: this is a folder of no known format, with "
            f"{source.describe().removeprefix('a folder with ')}; expected a motion file in it "
            "(halfphysics.clips(path) goes through a library)"
        )
    return FileError(
        f"{source.path}: no known motion format. Found {source.describe()}."
        f"{_like_amass(source)} Expected one of: {known}"
    )


def _like_amass(source: Source) -> str:
    """How to make an AMASS file of fields that are AMASS's but for their name or their container;
    empty for others."""
    fields = source.data if source.npz is None else source.npz
    if not isinstance(fields, Mapping) or "trans" not in fields:
        return ""
    poses = next((name for name in _POSES if name in fields), None)
    if poses is None:
        return ""
    npz = source.npz
    shape = shape_of(fields[poses]) if npz is None else npz.header(poses)[0]
    if amass.row_width(shape or ()) not in amass.COLUMNS:
        return ""
    if npz is not None:
        return f" These are AMASS's fields, but for '{poses}': name it '{_POSES[0]}'."
    named = "" if poses == _POSES[0] else f" with '{poses}' named '{_POSES[0]}'"
    return f" These are AMASS's fields: save them as an .npz (numpy.savez(path, **fields)){named}."
