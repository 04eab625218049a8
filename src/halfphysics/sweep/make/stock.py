"""A cache of clips, bodies and scenes for neighbouring variants.

Neighbouring variants share them, so only the last few are kept. Every value depends on its key
alone, not on earlier requests.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from halfphysics.base.digests import sha256_of
from halfphysics.baselines.options import options_of
from halfphysics.errors import FileError, InputError
from halfphysics.formats.datasets.assets import noted
from halfphysics.formats.loading import betas_for, furnished, model_for
from halfphysics.sweep.make.kept import Kept
from halfphysics.sweep.make.motion_factors import recorded_in_step, retimed

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.body.shape_space import ShapeSpace
    from halfphysics.body.shape_space import Source as ModelSource
    from halfphysics.geometry.mesh import MeshSource
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.sequence import Sequence as Clip
    from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
    from halfphysics.sweep.plan.inputs import Input

#: A source file: its absolute "path", and "sha256" of its content.
Source: TypeAlias = dict[str, str]

#: Number of cached values of each kind. A body takes some MB, a clip or a scene up to tens of MB.
CLIPS, MODELS, BODIES, SCENES, DIGESTS = 2, 2, 4, 3, 10_000


@dataclass(frozen=True, eq=False)
class Loaded:
    """A clip and its source files."""

    clip: Clip
    sources: tuple[Source, ...]


@dataclass(frozen=True, eq=False)
class Furnished:
    """A scene before any factor of its items, and its source files."""

    scene: Scene
    sources: tuple[Source, ...]


class Stock:
    """The last few clips, body models, bodies, grounded clips and scenes."""

    def __init__(self) -> None:
        self._digests: Kept[str] = Kept(DIGESTS)
        # If a key has the id of an object, the value keeps that object, so that Python does not
        # reuse the id while the key exists.
        self._clips: Kept[tuple[Any, Loaded]] = Kept(CLIPS)
        self._models: Kept[ShapeSpace] = Kept(MODELS)
        self._bodies: Kept[Body] = Kept(BODIES)
        self._adapted: Kept[tuple[Any, Loaded]] = Kept(BODIES)
        self._grounded: Kept[tuple[Any, tuple[Motion, ...]]] = Kept(BODIES)
        self._timed: Kept[tuple[Any, tuple[Motion, ...]]] = Kept(BODIES)
        self._scenes: Kept[tuple[Any, Furnished]] = Kept(SCENES)

    def clip(self, input: Input, options: Mapping[str, Any], body: Body | None) -> Loaded:
        """The clip in a file, or a scenario.

        Args:
            input: The input.
            options: Options of a scenario, in addition to those of its input.
            body: Body for a scenario; None: the scenario's own.
        """
        if input.kind == "file":
            key: Hashable = ("file", str(input.path), _key(input.options))
            return self._clips.get(key, lambda: (None, self._read(input)))[1]

        def make() -> tuple[Any, Loaded]:
            from halfphysics import scenarios

            given = {} if body is None else {"body": body}
            chosen = {**input.options, **options, **given}
            return body, Loaded(scenarios.load(input.name, **chosen), ())

        key = ("scenario", input.name, _key(input.options), _key(options), id(body))
        return self._clips.get(key, make)[1]

    def body(
        self,
        choice: BodyChoice,
        motion: Motion | None,
        shape: Mapping[str, float],
        own: Body | None,
    ) -> Body:
        """The chosen body, with the shape from the factors.

        Args:
            choice: The choice of body.
            motion: The motion with its betas, if they fit the model; None for a scenario.
            shape: Factors of the body by name: "stature" [m], "betas.K".
            own: The body of the clip, if it has one.

        Raises:
            InputError: The body cannot have the shape.
        """
        asked = choice.model is not None or choice.stature is not None or bool(shape)
        if own is not None and not asked:
            return own
        betas = {int(k.removeprefix("betas.")): v for k, v in shape.items() if k != "stature"}
        stature = shape.get("stature", choice.stature)
        if choice.model is None and own is not None and own.source and stature is None:
            return self._reshaped(own, own.source, betas)
        if choice.model is None:
            key: Hashable = ("default", _key(betas), stature)
            return self._bodies.get(key, lambda: _default(betas, stature))
        if "stature" in shape:
            raise InputError(
                f"body.stature: is for the default body, found it with the model {choice.model}, "
                "whose shape comes from betas. Leave it out, or vary body.betas.K"
            )
        return self._modelled(choice, motion, betas)

    def _reshaped(self, own: Body, source: ModelSource, betas: Mapping[int, float]) -> Body:
        """The body of a data set, with other shape numbers on its subject's template."""
        from halfphysics.body.body import Body

        template = own.template_source

        def make() -> Body:
            return Body.load(
                source.path,
                betas=_with_betas(own.betas, betas, "subject's body"),
                gender=None if own.gender == "unknown" else own.gender,
                v_template=None if template is None else template.path,
            )

        return self._bodies.get((source, template, own.betas.tobytes(), _key(betas)), make)

    def _modelled(
        self, choice: BodyChoice, motion: Motion | None, betas: Mapping[int, float]
    ) -> Body:
        from halfphysics.body.body import Body
        from halfphysics.body.model_files import read_model

        path = choice.path or Path(choice.model or "")

        def read(path: Any, **which: Any) -> ShapeSpace:
            return self._models.get((str(path), _key(which)), lambda: read_model(path, **which))

        if motion is None:
            # The people of a scenario take the given body.
            space = read(path, gender="neutral" if path.is_dir() else None)
            given = None
        else:
            space = model_for(motion, path, read)
            given = betas_for(motion, space)
        full = space.betas(given, stacklevel=3)
        full = _with_betas(full, betas, choice.name)
        key = (str(path), space.model, space.gender, full.tobytes())
        return self._bodies.get(key, lambda: Body.shaped(space, full))

    def adapted(
        self, input: Input, loaded: Loaded, bodies: tuple[Body, ...], settings: Settings
    ) -> Loaded:
        """The clip with hands adapted to what they hold, of these bodies with these settings.

        Weights and frictions are those before any factor: a thing that is made heavier may slip.
        """
        clip = loaded.clip
        if input.kind != "file" or not clip.recorded:
            return loaded
        options = input.motion_options
        if not options.adapt or options.objects != "free":
            return loaded

        def make() -> tuple[Any, Loaded]:
            own = bodies if len(bodies) > 1 else bodies[0]
            ready = replace(clip, body=own, settings=settings).adapted(grip=options.grip)
            # A clip in which nothing is held stays the clip: what was made of it is found again.
            made = loaded if ready.motions == clip.motions else replace(loaded, clip=ready)
            return (loaded, bodies), made

        said = _key(options_of(settings)), options.grip
        return self._adapted.get((id(loaded), *map(id, bodies), said), make)[1]

    def grounded(self, loaded: Loaded, bodies: tuple[Body, ...]) -> tuple[Motion, ...]:
        """The clip's motions, each with its lowest skin vertex at z = 0."""

        def make() -> tuple[Any, tuple[Motion, ...]]:
            pairs = zip(loaded.clip.motions, bodies, strict=True)
            return (loaded, bodies), tuple(motion.grounded(body) for motion, body in pairs)

        return self._grounded.get((id(loaded), *map(id, bodies)), make)[1]

    def timed(self, motions: tuple[Motion, ...], timing: Mapping[str, float]) -> tuple[Motion, ...]:
        """Motions at the speed and frame rate given by factors (`motion_factors.retimed`)."""
        speed, fps = timing.get("speed", 1.0), timing.get("fps")
        if speed == 1.0 and fps is None:
            return motions
        key = (*map(id, motions), speed, fps)
        return self._timed.get(key, lambda: (motions, retimed(motions, timing)))[1]

    def scene(self, choice: SceneChoice, loaded: Loaded, ground: bool, speed: float) -> Furnished:
        """The scene around a clip.

        Args:
            choice: A scene file, or the clip's own scene.
            loaded: The clip.
            ground: Whether to add a floor at z = 0 if the scene has no plane.
            speed: Speed factor of the recorded trajectories.
        """

        def make() -> tuple[Any, Furnished]:
            own = loaded.clip.scene
            own = own if speed == 1.0 else recorded_in_step(own, speed)
            words = (f"scenes: {choice.name}:", "objects: none", "ground: false")
            scene = furnished(own, choice.path or choice.file, (), (), ground, words=words)
            return loaded, Furnished(scene, self._sources_of(scene, choice))

        key = (str(choice.path or choice.file), id(loaded), ground, speed)
        return self._scenes.get(key, make)[1]

    def _read(self, input: Input) -> Loaded:
        options, path = input.motion_options, Path(input.path or input.name)
        with noted() as others:
            clip = replace(options, adapt=False).sequence(path)
        if options.model is not None and Path(options.model).is_file():
            others.append(Path(options.model))
        # The scene lists the meshes.
        meshes = {Path(source.path) for source in _sources_in(clip.scene)}
        left = [other for other in dict.fromkeys(others) if other.resolve() not in meshes]
        return Loaded(clip, self._sources([path, *left]))

    def _sources_of(self, scene: Scene, choice: SceneChoice) -> tuple[Source, ...]:
        """The scene's file and those of its meshes and articulated objects."""
        file = choice.path or choice.file
        return (
            *self._sources([] if file is None else [Path(file)]),
            *({"path": source.path, "sha256": source.sha256} for source in _sources_in(scene)),
        )

    def _sources(self, paths: Iterable[Path]) -> tuple[Source, ...]:
        """Files with their hashes; a folder stands for all files in it."""
        files: list[Path] = []
        for path in paths:
            inner = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
            files += [file.absolute() for file in inner]
        return tuple({"path": str(file), "sha256": self._digest(file)} for file in files)

    def _digest(self, file: Path) -> str:
        """SHA-256 (hex) of a file, computed again if its size or time has changed."""

        try:
            look = file.stat()
            key = (str(file), look.st_size, look.st_mtime_ns)
            return self._digests.get(key, lambda: sha256_of(file))
        except OSError as error:
            raise FileError(f"{file}: cannot be read: {error.strerror}") from None


def _sources_in(scene: Scene) -> Iterable[MeshSource]:
    """The sources of the meshes and articulated objects of a scene."""
    items: Iterable[Any] = (
        *scene.statics.values(),
        *scene.objects.values(),
        *scene.articulated.values(),
    )
    return (item.source for item in items if item.source is not None)


def _default(betas: Mapping[int, float], stature: float | None) -> Body:
    from halfphysics.body.body import Body

    if not betas:
        return Body.default(stature=stature)
    full = _with_betas(Body.default().betas, betas, "default body")
    return Body.default(full, stature=stature)


def _with_betas(full: Any, betas: Mapping[int, float], name: str) -> Any:
    """Shape numbers (n,) with some of them replaced."""
    made = np.array(full, dtype=np.float64)
    for k, value in betas.items():
        if k >= len(made):
            raise InputError(
                f"body.betas.{k}: the {name} has {len(made)} shape numbers, betas.0 to "
                f"betas.{len(made) - 1}"
            )
        made[k] = value
    return made


def _key(options: Mapping[Any, Any]) -> Hashable:
    """Options as a key that does not depend on their order."""
    return tuple(sorted((str(name), repr(value)) for name, value in options.items()))
