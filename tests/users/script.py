"""A script as a user writes it, which `mypy --strict` accepts (`./run check`) and a test runs.

python tests/users/script.py FOLDER
"""

from __future__ import annotations

import copy
import logging
import pickle
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import halfphysics as hp

logger = logging.getLogger("users.script")


def walk(frames: int = 20, fps: float = 30.0) -> hp.Motion:
    """A T-pose that is moved along x."""
    translation: NDArray[np.float64] = np.zeros((frames, 3))
    translation[:, 0] = np.arange(frames) / fps
    translation[:, 2] = 0.95
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = (np.pi / 2, 0.0, 0.0)
    return hp.Motion(translation, rotations, fps)


def room() -> hp.Scene:
    """A floor, and a ball before the person."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.15), mass=0.5, position=(0.45, -0.4, 1.0))
    return scene


def loads(result: hp.Result, name: str) -> float:
    """Largest force of the contacts with an item [N]."""
    index = result.names.index(name)
    contacts = result.contacts
    rows = contacts[contacts.other == index]
    return float(rows.strength.max()) * result.fps if len(rows) else 0.0


def one_frame_at_a_time(motion: hp.Motion, scene: hp.Scene) -> list[float]:
    """Clearance of every frame, by a simulator and by its copy."""
    simulator = hp.Simulator(scene, settings=hp.Settings(weight=False), fps=motion.fps)
    simulator.reset(motion[0])
    simulator.step(motion[1])
    again: hp.Simulator = pickle.loads(pickle.dumps(simulator))
    pose: hp.Pose = motion[2]
    return [one.step(pose).clearance for one in (simulator, again)]


def main(folder: Path) -> None:
    """Simulate, look at the result in each way, and save it."""
    motion, scene = walk(), room()
    settings = hp.Settings(weight=False, stiffness={"arms": 2.0})
    with hp.progress():
        result: hp.Result = hp.simulate(motion, scene, settings=settings, progress=True)
    print(result, result.people[0], result.contacts, sep="\n")

    frame = result.contacts.to_dataframe()
    table = result.contacts.to_dataframe("polars")
    dataset = result.to_xarray(joints=True)
    print(len(frame), len(table), dict(dataset.sizes))
    figure = result.plot(("clearance", "forces"))
    figure.savefig(folder / "charts.png")

    html: str = result._repr_html_()
    (folder / "result.html").write_text(html, encoding="utf-8")
    other: hp.Result = copy.deepcopy(result)
    other.save(folder / "result.npz")
    loaded = hp.Result.load(folder / "result.npz")
    error: float = hp.metrics.mpjpe(loaded.motion, result.motion, hp.Body.default())
    first, second = one_frame_at_a_time(motion, scene)
    logger.info("ball: %.0f N, error %.3f mm", loads(result, "ball"), error)
    print(f"{loads(result, 'ball'):.1f} N, error {error:g} mm, same: {first == second}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
