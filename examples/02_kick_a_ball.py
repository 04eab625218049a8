"""The same kick at a football, a medicine ball and a 200 kg ball: each leaves as its mass says.

Run it: python examples/02_kick_a_ball.py
"""

from __future__ import annotations

import numpy as np

import halfphysics as hp


def kick(mass: float) -> tuple[hp.Result, float]:
    """The result for a ball of `mass` [kg], and the ball's highest speed [m/s]."""
    story = hp.scenarios.load("kick_ball", mass=mass)
    result = hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)
    path = result.objects["ball"].position
    speed = float(np.linalg.norm(np.diff(path, axis=0), axis=1).max() * result.fps)
    return result, speed


def main() -> dict[float, float]:
    """Speeds [m/s] by mass [kg]."""
    speeds = {}
    for mass in (0.43, 5.0, 200.0):
        result, speeds[mass] = kick(mass)
        ball = result.names.index("ball")
        hits = result.contacts[(result.contacts.other == ball) & (result.contacts.person == 0)]
        impulse = float(np.linalg.norm(hits.impulse.sum(axis=0)))
        print(f"{mass:6.2f} kg: {speeds[mass]:5.2f} m/s after an impulse of {impulse:5.2f} N s")
    return speeds


if __name__ == "__main__":
    main()
