"""Limits on the slip of a grasp, and on the evenness of its force."""

from __future__ import annotations

#: Largest slip of a grasp while it is shaken, carried and turned over.
SLIP, TURN = 10.0, 15.0  # [mm], [degrees]


#: Held still: a grip as firm as a person's, without tremor or creep.
FORCE, SPREAD, PEAK = (27.0, 50.0), 0.05, 100.0  # [N], share, [N]


JITTER, CREEP = 1e-3, 1e-3  # [m/s^2], [mm/s]; seen: 8e-5, 1e-5


#: Tolerance of free fall [m/s^2], and its start after the hand begins to open [s].
FALL, FREED = 0.05, 0.2


#: The hand comes to rest this long after the lift [s].
SETTLED = 0.3
