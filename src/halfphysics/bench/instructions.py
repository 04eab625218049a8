"""Instructions of the core per substep with contact, counted by valgrind where it is installed.

Counts hardly depend on the machine or on what else it does: 1 % more is 1 % more. A process of its
own plays a clip once, another plays it twice; the difference is one pass, without start and set-up.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator

import numpy as np

from halfphysics.bench import grasp, handling, wall
from halfphysics.bench.clips import SUBSTEPS, body
from halfphysics.bench.free import core_loop
from halfphysics.bench.pressing import Play
from halfphysics.bench.record import Options, Record
from halfphysics.errors import HalfPhysicsError
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

#: Goal for a substep with contact at stiffness 1 [millions of instructions]: kinematics, an O(n)
#: factor, twelve rows and one verification are some 0.2; three times that, and a little.
BAR = 0.67
#: Setting -> (clip, stiffness of the default drive).
SETTINGS = {
    "wall, stiffness 1": ("wall", 1.0),
    "grasp, stiffness 1": ("grasp", 1.0),
    "lift, stiffness 1": ("lift", 1.0),
    "glass, stiffness 1": ("glass", 1.0),
    "wall, stiffness 0": ("wall", 0.0),
}
#: Longest time that a process may take under valgrind [s]; they take about one minute.
_LIMIT = 1200.0
_COUNTED = re.compile(r"I\s+refs:\s+([\d,]+)")


def instructions(options: Options) -> Iterator[Record]:
    """Millions of instructions per substep with contact, skin, default drive, N = 8."""
    valgrind = shutil.which("valgrind")
    if valgrind is None:
        return
    # What is kept of the body on disk depends on the processor, and valgrind's is another: the
    # first process may have to make it.
    counted(valgrind, "wall", 1.0, 0, quick=True)
    for name, (clip, stiffness) in SETTINGS.items():
        once, _ = counted(valgrind, clip, stiffness, 1, options.quick)
        twice, contact = counted(valgrind, clip, stiffness, 2, options.quick)
        yield Record(
            case="instructions",
            setting=name,
            frames=len(played(clip, options.quick).motion) - 1,
            unit="M instructions",
            ours=(1e-6 * (twice - once) / contact,),
            checks={
                "substeps with contact": (contact, None),
                "goal [M instructions]": (BAR, None),
            },
        )
        if options.quick:
            return


def counted(
    valgrind: str, clip: str, stiffness: float, passes: int, quick: bool
) -> tuple[int, int]:
    """Instructions of a process that plays a clip, and the clip's substeps with contact."""
    program = [
        valgrind,
        "--tool=cachegrind",
        "--cache-sim=no",
        f"--cachegrind-out-file={os.devnull}",
    ]
    arguments = [clip, str(stiffness), str(passes), str(int(quick))]
    done = subprocess.run(
        [*program, sys.executable, "-m", __name__, *arguments],
        env={**os.environ, "PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=_LIMIT,
        check=False,
    )
    found = _COUNTED.search(done.stderr)
    if done.returncode != 0 or found is None:
        raise HalfPhysicsError(f"valgrind counted nothing: {done.stderr.strip()[-500:]}")
    return int(found[1].replace(",", "")), int(done.stdout)


def played(clip: str, quick: bool) -> Play:
    """The motion and the scene of a clip."""
    plays: dict[str, Callable[[], Play]] = {
        "wall": wall.walking,
        "grasp": grasp.lifting,
        "lift": lambda: handling.played("lift_suitcase"),
        "glass": lambda: handling.played("grasp_glass", stages=handling.STAGES),
    }
    play = plays[clip]()
    return Play(motion=play.motion[:30], scene=play.scene) if quick else play


def main(clip: str, stiffness: str, passes: str, quick: str) -> None:
    """Play a clip so many times, then print how many of its substeps have contact."""
    play = played(clip, quick == "1")
    settings = Settings(stiffness=float(stiffness), substeps=SUBSTEPS)
    simulator = Simulator(play.scene, body=body(), settings=settings, fps=play.motion.fps)
    play_once = core_loop(simulator, play.motion)
    for _ in range(int(passes)):
        play_once()
    core = simulator.world.stepper
    core.keep_times(True)
    play_once()
    print(np.count_nonzero(np.asarray(core.solve_times()) > 0.0))


if __name__ == "__main__":
    main(*sys.argv[1:])
