"""A kick at a ball for examples/c/walk.c: writes its world and its poses.

python examples/c/write_world.py kick.hpw kick.poses
"""

import sys
from pathlib import Path

import numpy as np

import halfphysics as hp


def main() -> None:
    """Write the two files."""
    world, poses = map(Path, sys.argv[1:3])
    sequence = hp.scenarios.load("kick_ball")
    body, motion = sequence.body, sequence.motion
    sim = hp.Simulator(sequence.scene, body=body, settings=sequence.settings, fps=motion.fps)
    sim.reset(motion[0])  # the file has the axes of the poses
    sim.save_world(world)
    rows = np.column_stack([motion.translation, motion.rotations.reshape(len(motion), -1)])
    poses.write_bytes(np.append(motion.fps, rows).astype("<f8").tobytes())


if __name__ == "__main__":
    main()
