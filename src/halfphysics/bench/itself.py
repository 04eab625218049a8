"""Free motion with self-contact beside free motion without: what keeping off oneself costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics
from halfphysics.bench.clips import SUBSTEPS, body, clips
from halfphysics.bench.free import core_loop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import AS_IT_IS, Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator

Array = NDArray[np.float64]


def itself(options: Options) -> Iterator[Record]:
    """A row for every clip and number of substeps; a ratio of 1 says that self-contact is free."""
    for name, motion in clips(options):
        for substeps in (1, SUBSTEPS):
            done = measure(
                "itself",
                f"{name}, N={substeps}",
                len(motion) - 1,
                options,
                ours=_loop(motion, substeps, "skin", True),
                parts=_loop(motion, substeps, "parts", True),
                peer=_loop(motion, substeps, "skin", False),
            )
            result = simulate(
                motion, Scene(), body=body(), settings=_settings(substeps, "skin", True)
            )
            stepped = np.count_nonzero(np.asarray(result.diagnostics["planes"]))
            away = metrics.mpjpe(result.motion, motion, body())
            checks = {"frames stepped": (float(stepped), None), "MPJPE [mm]": (away, None)}
            yield replace(done.record, checks=checks)


def _settings(substeps: int, contact: str, self_contact: bool) -> Settings:
    """The motion is followed as it is."""
    changes = {"substeps": substeps, "contact": contact, "self_contact": self_contact}
    return Settings(**{**AS_IT_IS, **changes})


def _loop(motion: Motion, substeps: int, contact: str, self_contact: bool) -> Callable[[], Array]:
    settings = _settings(substeps, contact, self_contact)
    return core_loop(Simulator(body=body(), fps=motion.fps, settings=settings), motion)
