"""The same kick at a football, a medicine ball and a 200 kg ball: each leaves as its mass says.

Run it: python examples/02_kick_a_ball.py
"""

from __future__ import annotations

import numpy as np

import halfphysics as hp


def kick(mass: float) -> tuple[float, float, float]:
    """The highest horizontal speed of a ball of `mass` [kg], and what gave it, along its way.

    Returns:
        Speed [m/s], the mean over one frame; impulse of the person and of the floor's friction on
        the ball until then [N s].
    """
    story = hp.scenarios.load("kick_ball", mass=mass)
    result = hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)
    velocities = np.diff(result.objects["ball"].position[:, :2], axis=0) * result.fps
    speeds = np.linalg.norm(velocities, axis=1)
    frame = int(speeds.argmax()) + 1
    way = velocities[frame - 1] / speeds[frame - 1]

    contacts = result.contacts[result.contacts.frame <= frame]
    kicks = (contacts.person == 0) & (contacts.other == result.names.index("ball"))
    # Impulses act on the person where there is one, so the ball gets the opposite.
    given = -contacts.impulse[kicks][:, :2].sum(axis=0) @ way
    floor = contacts.impulse[contacts.person < 0][:, :2].sum(axis=0) @ way
    return float(speeds.max()), float(given), float(floor)


def main() -> dict[float, tuple[float, float, float]]:
    """Mass [kg] -> speed [m/s], impulses of the person and of the floor [N s]."""
    found = {}
    for mass in (0.43, 5.0, 200.0):
        found[mass] = speed, given, floor = kick(mass)
        print(
            f"{mass:6.2f} kg: {speed:.2f} m/s, {mass * speed:.2f} kg m/s: "
            f"the feet gave {given:.2f} N s, the floor's friction took {-floor:.2f} N s"
        )
    return found


if __name__ == "__main__":
    main()
