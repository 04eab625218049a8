"""Table 2 on scenes of the user: clips with their scenes, and scene meshes with a walk.

Meshes are found by suffix, clips by content. Each file is opened by its own task; a file that
cannot be used fails alone, with its cause.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path

from evidence.model import Options, Outcome, Task
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.simulation.sequence import Sequence

#: Largest number of scenes of a folder, in a full and in a quick report.
MOST, QUICK_MOST = 40, 4
#: Duration taken of a clip [s], in a full and in a quick report.
_SECONDS, _QUICK_SECONDS = 20.0, 6.0
MESHES = frozenset({".ply", ".glb", ".gltf", ".obj", ".stl", ".off"})
_CLIPS = frozenset({".npz", ".npy", ".pkl", ".p", ".pt"})


def tasks(options: Options) -> list[Task]:
    """One task per mesh or clip, in the order of their paths."""
    folder = Path(options.data["scenes"])
    most = QUICK_MOST if options.quick else MOST
    out = []
    for i, (path, clip) in enumerate(options.once("scenes", lambda: found(folder))[:most]):
        words = str(path.relative_to(folder).with_suffix("")) + (f"-{clip}" if clip else "")
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", words)[-60:].strip("-")
        arguments = {
            "path": str(path),
            "clip": clip,
            "seed": options.seed,
            "quick": options.quick,
        }
        out.append(
            Task(
                key=f"scene-{i:02d}-{name}",
                function=".rooms.brought:brought",
                arguments=arguments,
                inputs=_read(path),
                seconds=3.0 if options.quick else 20.0,
            )
        )
    return out


def _read(path: Path) -> tuple[str, ...]:
    """The files that a task reads: for a .gltf also those beside it, which hold its vertices."""
    return (str(path), str(path.parent)) if path.suffix.lower() == ".gltf" else (str(path),)


def found(folder: Path) -> list[tuple[Path, str | None]]:
    """Possible scenes: meshes, and clips (path, name in a file of several).

    Replica has each room twice: one of its meshes is taken. Meshes in the folder of a clip belong
    to the clip.

    Raises:
        FileError: The folder has none.
    """
    from halfphysics.formats.library import clips

    below = [p for p in sorted(folder.rglob("*")) if p.is_file()]
    meshes = {p for p in below if p.suffix.lower() in MESHES}
    meshes -= {
        p for p in meshes if p.parent.name == "habitat" and p.parents[1] / "mesh.ply" in meshes
    }
    motions = [(clip.path, clip.name) for clip in clips(folder)]
    known = {path for path, _ in motions}
    meshes = {p for p in meshes if not known & set(p.parents)}
    # Files that should be clips and cannot be read: their tasks report why.
    broken = [p for p in below if p.suffix.lower() in _CLIPS and not known & {p, *p.parents}]
    out = [*((p, None) for p in meshes), *motions, *((p, None) for p in broken)]
    if not out:
        raise FileError(
            f"{folder}: no scene in it, expected meshes ({', '.join(sorted(MESHES))}) or clips "
            "that come with their scene"
        )
    return sorted(out, key=lambda one: (str(one[0]), one[1] or ""))


def brought(path: str, clip: str | None, seed: int, quick: bool) -> Outcome:
    """Play one scene: a walk through a mesh, or a clip in its scene.

    Raises:
        FileError: It cannot be read, or a clip has no scene. InputError: No place to stand in it.
    """
    from evidence.runs.visiting import CLAIMED, measured

    file = Path(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        sequence = _walk(file, seed) if file.suffix.lower() in MESHES else _clip(file, clip, quick)
        ways = ("ours",) if quick else CLAIMED
        outcome = measured(sequence, ways, False, quick)
    shapes = [s.shape for s in sequence.scene.statics.values()]
    about = {
        "scene": file.name if clip is None else f"{file.name}, {clip}",
        "triangles": sum(len(s.faces) for s in shapes if isinstance(s, Mesh)),
    }
    return Outcome(values={**outcome.values, **about})


def _walk(file: Path, seed: int) -> Sequence:
    from evidence.rooms.standing import walk_through
    from halfphysics.body.body import Body
    from halfphysics.geometry.mesh_files import load_mesh

    mesh, _ = load_mesh(file)
    try:
        return walk_through(mesh, Body.default(), seed)
    except InputError as error:
        raise FileError(f"{file}: {error}") from None


def _clip(file: Path, clip: str | None, quick: bool) -> Sequence:
    from halfphysics.formats.registry import load_sequence

    given = load_sequence(file, clip=clip)
    if not given.scene.statics:
        raise FileError(
            f"{file}: a motion without a scene; motions alone are shown with --data clips=FOLDER"
        )
    motion, body = given.motions[0], given.bodies[0]
    if body is None:  # the default body has no use for betas of other models
        motion = replace(motion, betas=None)
    count = max(2, round((_QUICK_SECONDS if quick else _SECONDS) * motion.fps))
    return replace(given, motion=motion[:count], body=body)
