"""A motion of your own in a scene of your own, saved and looked at again.

Run it: python examples/03_own_scene.py [FOLDER]      (writes into out/own_scene by default)
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import halfphysics as hp

SCENE = """\
version: 1
statics:
  floor: {shape: plane}
  post: {shape: cylinder, radius: 0.05, length: 2.0, position: [1.0, 0.55, 1.0]}
objects:
  crate:
    shape: box
    size: [0.4, 0.5, 0.4]
    mass: 5
    friction: 0.5
    position: [0.8, -0.1, 0.2]
friction:
  - [crate, floor, 0.2]
"""


def glide(body: hp.Body, frames: int = 60, fps: float = 30.0) -> hp.Motion:
    """A T-pose that glides along +x at 1 m/s, arms out to both sides, 2 cm above the floor.

    SMPL-X bodies are y-up and look along z at rest: the root's rotation turns y to z and z to x.
    The pelvis is at body.rest_joints[0] + translation.
    """
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = np.array([1.0, 1.0, 1.0]) * (2.0 * np.pi / 3.0 / np.sqrt(3.0))
    pelvis = np.zeros((frames, 3))
    pelvis[:, 0] = np.arange(frames) / fps
    return hp.Motion(pelvis - body.rest_joints[0], rotations, fps).grounded(body, z=0.02)


def main(folder: Path) -> hp.Result:
    """Write room.yaml and motion.npz, simulate, write result.npz and read it back."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "room.yaml").write_text(SCENE, encoding="utf-8")
    body = hp.Body.default(stature=1.80)
    glide(body).save(folder / "motion.npz")

    # From here on as with files of your own.
    motion = hp.Motion.load(folder / "motion.npz")
    scene = hp.Scene.load(folder / "room.yaml")
    result = hp.simulate(motion, scene, body=body, settings=hp.Settings(stiffness=3.0))
    result.save(folder / "result.npz")

    again = hp.Result.load(folder / "result.npz")
    print(again.summary())
    print(f"any reader of motion files opens it too: {hp.Motion.load(folder / 'result.npz')}")
    return again


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/own_scene"))
