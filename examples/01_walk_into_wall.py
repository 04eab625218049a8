"""A person walks into a wall: the body stops, the walk goes on at the wall.

Run it: python examples/01_walk_into_wall.py
"""

from __future__ import annotations

import numpy as np

import halfphysics as hp


def main() -> hp.Result:
    """The wall's face is at x = 1.95 m, the motion walks on to x = 4 m."""
    motion = hp.scenarios.load("walk_into_wall").motion
    body = hp.Body.default()

    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("wall", hp.Box((0.1, 3.0, 2.4)), position=(2.0, 0.0, 1.2))

    before = hp.metrics.penetration(motion, body, scene)
    result = hp.simulate(motion, scene, body=body)
    after = hp.metrics.penetration(result.motion, body, scene)

    print(result.summary())
    print(f"reference: {before.rate_percent:.2f} % of the skin in things, on average")
    print(f"simulated: {after.rate_percent:.2f} %, deepest {after.depth_max_mm:.2f} mm")
    print(f"the body went to x = {result.motion.translation[:, 0].max():.2f} m")

    touched = result.contacts[result.contacts.other == result.names.index("wall")]
    parts, rows = np.unique(touched.part, return_counts=True)
    for part in parts[np.argsort(-rows)][:5]:
        print(f"  {hp.JOINT_NAMES[part]} touched the wall")
    return result


if __name__ == "__main__":
    main()
