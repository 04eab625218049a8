"""The convex problem that spreads a wrench over the places that can carry.

For every frame, with the wrench w that is needed (force and moment about the pelvis), places at
r_i from the pelvis with readiness b_i and the friction cone K_i = {|f_t| <= mu f_n}::

    minimise  1/2 |S (sum_i J_i f_i - w)|^2 + 1/2 PENALTY^2 sum_i |f_i|^2 / b_i^2,   f_i in K_i

    J_i f = (f, r_i x f),    S: forces as they are, moments times MOMENTS

|f|^2 stands for f_n^2 + (SHEAR f_t)^2, and so does the distance of a projection. It always has one
solution, which changes continuously with w, r and b, so it is as smooth in time as they are. Its
dual has six unknowns, the scaled wrench y that is missing: with g_i = b_i^2 / PENALTY^2 J_i^T S y
each force is the projection of g_i on K_i, and y the minimum of

    1/2 |y|^2 - y . S w + 1/2 sum_i PENALTY^2 / b_i^2 |proj_i(g_i)|^2

which is strongly convex with a continuous gradient: Newton steps of six unknowns, each shortened
to where the dual is flat along it, at most `STEPS` of them. The core takes them
(native/support/wrench_spread.cpp); `tests/support/references/wrench_qp.py` has the same in plain
numpy. The tests hold both equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Weight of a newton metre of missing moment in newtons: the inverse of a lever arm [1/m].
MOMENTS = 4.0
#: Weight of the forces themselves, which shares them evenly where many places could carry. With
#: 0.02 who floats by 3 cm misses 5 to 10 % of the weight; less only makes the problem stiffer.
PENALTY = 0.005
#: Weight of what is tangential of a force relative to its normal part: whoever rests does not push
#: one limb against another by friction. At 1 a person who sits presses the feet back with 170 N.
SHEAR = 3.0
#: Penalties that are solved on the way to `PENALTY`, each from the last one's solution.
PENALTIES = (0.1, 0.02, PENALTY)
#: Most Newton steps of a frame (it takes about 5), and most searches along a step.
STEPS, SEARCHES = 40, 30
#: A frame is solved where the gradient is under this part of the wrench that is needed.
TOLERANCE = 1e-10


def spread(
    wrench: Array, frame: Ints, arm: Array, normal: Array, friction: Array, ready: Array
) -> Array:
    """Forces at the places that together come closest to a wrench in every frame.

    Args:
        wrench: Force [N] and moment [N m] that is needed, shape (T, 6).
        frame: Frame of every place (n,), ascending.
        arm: Of every place from the point of the moments (n, 3) [m].
        normal: Unit vectors, along which the places push (n, 3).
        friction: Coefficients (n,).
        ready: Readiness (n,), over 0, at most 1.

    Returns:
        Forces (n, 3) [N], each in its cone.
    """
    from halfphysics import _native

    used, start = np.unique(frame, return_index=True)
    if not len(used):
        return np.zeros((0, 3))
    force: Array = _native.spread_wrenches(
        np.ascontiguousarray(wrench[used]),
        np.append(start, len(frame)).astype(np.int32),
        np.ascontiguousarray(arm),
        np.ascontiguousarray(normal),
        np.ascontiguousarray(friction),
        np.ascontiguousarray(ready),
        penalties=np.array(PENALTIES),
        moments=MOMENTS,
        shear=SHEAR,
        tolerance=TOLERANCE,
        steps=STEPS,
        searches=SEARCHES,
    )
    return force
