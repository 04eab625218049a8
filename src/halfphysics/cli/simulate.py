"""halfphysics simulate: give a motion a body in a scene."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import (
    BaselineOptions,
    BodyOptions,
    MotionOptions,
    SceneOptions,
    progress,
)
from halfphysics.cli.outputs import Outputs
from halfphysics.errors import InputError
from halfphysics.formats.loading import is_furnished
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics simulate walk.npz --scene room.yaml --out result.npz
halfphysics simulate kick.npz --object ball=sphere:0.11,mass=0.43,position=1:0:0.11 --out r.npz
halfphysics simulate walk.npz --body SMPLX_NEUTRAL.npz --static wall=box:0.1:4:2,position=2:0:1
halfphysics simulate walk.npz --scene room.yaml --page walk.html --film walk.mp4 --open
halfphysics simulate a.npz b.npz --stiffness 10 --root recover --out two_people.npz"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Give a motion a body in a scene: what is in its way stops it, what it meets is pushed."""

    motions: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")]
    """Motion files, one per person."""
    grounded: bool = False
    """Move each motion along z so that its lowest skin vertex is at z = 0."""
    outputs: tyro.conf.OmitArgPrefixes[Outputs] = field(default_factory=Outputs)
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)
    settings: tyro.conf.OmitArgPrefixes[Settings] = field(default_factory=Settings)
    baseline: tyro.conf.OmitArgPrefixes[BaselineOptions] = field(default_factory=BaselineOptions)

    def run(self) -> None:
        """Simulate, print the summary, write the files."""
        from halfphysics.simulation.simulate import simulate

        if not self.motions:
            raise InputError(
                "simulate: no motion file. halfphysics simulate --help explains the options"
            )
        self.outputs.check(*self.motions, self.scene.scene, self.person.body)
        settings = self.baseline.applied(self.settings)
        sequences = [
            self.motion_file.sequence(
                path, body=self.person.instead_of, settings=settings, ground=self.scene.ground
            )
            for path in self.motions
        ]
        motions = [motion for sequence in sequences for motion in sequence.motions]
        scene = self.scene.load(self._recorded(sequences))
        # `instead_of` has given everybody one.
        bodies = [body for sequence in sequences for body in sequence.bodies if body is not None]
        if self.grounded:
            motions = [m.grounded(body) for m, body in zip(motions, bodies, strict=True)]
        result = simulate(
            motions,
            scene,
            body=bodies,
            settings=settings,
            allow_mismatch=self.person.allow_mismatch,
            progress=progress(),
        )
        print(result.summary())
        self.outputs.write(result, ", ".join(path.name for path in self.motions))

    def _recorded(self, sequences: list[Sequence]) -> Scene:
        """The scene of the data sets: static geometry and objects."""
        full = [s.scene for s in sequences if is_furnished(s.scene)]
        if len(full) > 1:
            raise InputError(
                "simulate: more than one motion brings a scene of its own, and there is one world. "
                "Say --objects none and give the scene with --scene"
            )
        return full[0] if full else sequences[0].scene
