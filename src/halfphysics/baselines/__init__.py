"""Other ways to put a motion into a simulation, to compare with: docs/physics.md, "Baselines".

    hp.simulate(motion, scene, settings=hp.baselines.Kinematic(substeps=34))

Each baseline is a kind of `halfphysics.Settings` and goes wherever those go; a result keeps it.
`from_options` makes settings of flat options, as the command line and result files have them.
"""

from halfphysics.baselines.options import from_options, options_of, with_options
from halfphysics.baselines.settings import (
    Ablation,
    EngineKinematic,
    EngineVelocity,
    Interpolated,
    Kinematic,
    Positions,
    Torque,
)

__all__ = [
    "Ablation",
    "EngineKinematic",
    "EngineVelocity",
    "Interpolated",
    "Kinematic",
    "Positions",
    "Torque",
    "from_options",
    "options_of",
    "with_options",
]
