"""halfphysics evaluate: measure a result or a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import (
    BodyOptions,
    File,
    MotionOptions,
    SceneOptions,
    check_output,
    progress,
    refuse_options,
)
from halfphysics.errors import InputError
from halfphysics.formats.loading import GROUND

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import PersonResult

EXAMPLES = """\
halfphysics evaluate result.npz
halfphysics evaluate walk.npz --scene room.yaml
halfphysics evaluate mine.npz --reference recorded.npz --body SMPLX_NEUTRAL.npz"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Measure a result against its reference, or a motion against a scene or a reference.

    Penetration counts all skinned vertices; MPJPE is the mean error over 55 joints with the
    pelvis subtracted, MPJPE-g without. Of a result, scene, body and reference are known, and its
    summary is printed first.
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RESULT_OR_MOTION")]
    """A result of `simulate`, or a motion file."""
    reference: File = None
    """Motion to compare with; of a result, its reference motion if not given. Of a result of
    several people: a file of as many, or of the same names."""
    json: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Of a result: write every measure of docs/metrics.md as JSON."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Print the table of measures."""
        from halfphysics.cli import measures
        from halfphysics.formats.results.result_file import is_result
        from halfphysics.motion.motion import Motion

        if self.json is not None:
            model = self.motion_file.model
            inputs = (self.scene.scene, self.person.body, None if model is None else Path(model))
            check_output(self.json, self.file, self.reference, *inputs)
        if is_result(self.file):
            why = (
                "a result has its own frames. The options for motion files are for motions; leave "
                "them out"
            )
            refuse_options(self.file, why, self.motion_file)
            self._result()
            return
        scene = self.scene.load() if self.scene.given else None
        if self.json is not None:
            raise InputError(
                f"--json: {self.file} is a motion alone; expected a result of simulate"
            )
        motion = self.motion_file.load(self.file)
        if scene is None and self.reference is None:
            raise InputError(
                f"{self.file}: a motion alone, nothing to measure it against. Add --scene (or "
                "--static) or --reference"
            )
        reference = None if self.reference is None else Motion.load(self.reference)
        body = self.person.load(motion)
        print(measures.of_motion(motion, body, scene, reference, progress=progress()))

    def _result(self) -> None:
        import dataclasses

        from halfphysics.cli import measures
        from halfphysics.results.result import Result

        # A model file that has moved is given anew, for the result cannot be read without.
        body = self.person.load(_first(self.file)) if self.person.given else None
        result = Result.load(self.file, body=body)
        if self.scene.given:
            # A floor is added where the simulation had it.
            ground = self.scene.ground and GROUND in result.names
            scene = dataclasses.replace(self.scene, ground=ground).load()
            result = Result.load(self.file, scene=scene, body=body)
        people = list(result.people)
        if self.person.given or self.person.mass is not None:
            bodies = [self.person.instead_of(p.body, p.motion) for p in people]
            people = [dataclasses.replace(p, body=b) for p, b in zip(people, bodies, strict=True)]
        if self.reference is not None:
            people = [_beside(self.reference, people, k) for k in range(len(people))]
        result = dataclasses.replace(result, people=tuple(people))
        print(result.summary())
        print()
        for index, person in enumerate(people):
            if len(people) > 1:
                print(f"{person.name}:")
            print(measures.of_result(result, index, progress=progress()))
        if self.json is not None:
            import json

            from halfphysics.base.atomic import atomic_write
            from halfphysics.cli.measures_json import of_result

            content = [of_result(result, index) for index in range(len(people))]
            with atomic_write(self.json) as handle:
                handle.write((json.dumps({"people": content}, indent=1) + "\n").encode())


def _first(path: Path) -> Motion:
    """The motion of the first person of a result, without its body."""
    from halfphysics.base.npz import Npz
    from halfphysics.formats.results.motion_of_result import first_person
    from halfphysics.formats.results.unfinished import is_unfinished
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

    if is_unfinished(path):  # no archive yet
        return Result.load(path).motion
    return Motion.load(path, clip=first_person(Npz(path)))


def _beside(path: Path, people: Sequence[PersonResult], index: int) -> PersonResult:
    """One of the people of a result beside their motion in a file that they are compared with."""
    import dataclasses

    from halfphysics.judging.truths import reference_of

    person = people[index]
    reference = reference_of(path, person.name, index=index, count=len(people))
    # What hands were to hold is still the result's.
    if len(reference) == len(person.motion):
        reference = dataclasses.replace(reference, holds=person.reference.holds)
    return dataclasses.replace(person, reference=reference)
