"""Opens hostile files one after the other in this process and says what came of each.

    PYTHONPATH=src:tests python -m support.files.open_hostile FOLDER [WORDS ...]

prints a line of JSON for each attack: its name, seconds by the clock and of a processor (`work`),
MB of memory above what was held before, and the error ("ours": of `halfphysics.errors`). WORDS
choose attacks by parts of their names.
"""

from __future__ import annotations

import json
import os
import sys
import time
import warnings
from pathlib import Path

import halfphysics as hp
from halfphysics.base.machine import limit_memory
from halfphysics.errors import HalfPhysicsError
from halfphysics.scene import mjcf_process
from support.files.hostile import ATTACKS, HARMLESS

#: What this process may allocate, so that an attack that succeeds does not take the machine along.
MEMORY = 4 * 2**30
#: Time that MuJoCo has [s]: less than outside of tests, which are to be quick.
MUJOCO = 1.0


def peak() -> float:
    """Largest memory since `forget` [MB]; 0 where the system does not tell."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


def forget() -> None:
    """Count the largest memory from now on."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return


def work() -> float:
    """Processor time of this process and of the children that have ended [s]."""
    return sum(os.times()[:4])


OPENERS = {
    "motion": hp.load_sequence,
    "body": hp.Body.load,
    "scene": hp.Scene.load,
    "articulated": lambda path: hp.Scene().add_articulated("it", path),
    "mesh": lambda path: hp.Scene().add_static("it", path),
}


def opened(kind: str, path: Path) -> dict[str, object]:
    """What comes of opening one file."""
    forget()
    before, start, worked = peak(), time.monotonic(), work()
    try:
        OPENERS[kind](path)
        kept, said = "nothing", ""
    except HalfPhysicsError as error:
        kept, said = "ours", str(error)
    except BaseException as error:
        kept, said = type(error).__name__, str(error)
    return {
        "seconds": time.monotonic() - start,
        "work": work() - worked,
        "megabytes": peak() - before,
        "error": kept,
        "said": said,
    }


def main() -> None:
    folder, words = Path(sys.argv[1]), sys.argv[2:]
    limit_memory(MEMORY)
    mjcf_process.SECONDS = MUJOCO
    warnings.simplefilter("ignore")
    cases = [(kind, name, make) for kind, all_ in ATTACKS.items() for name, make in all_.items()]
    cases += [("mesh", name, make) for name, make in HARMLESS.items()]
    for kind, name, make in cases:
        if words and not any(word in name for word in words):
            continue
        own = folder / name
        own.mkdir()
        found = opened(kind, make(own))
        print(json.dumps({"name": name, **found}), flush=True)


if __name__ == "__main__":
    main()
