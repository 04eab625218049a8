"""The campaign behind `campaigns/test_torsion.py`: what spins stops as uniform pressure says.

    PYTHONPATH=src:tests python -m campaigns.torsion

Prints the deceleration of a spin over that of the closed form, mu g (mean distance) / k^2:
shapes of 1 cm to 2 m on planes, boxes, meshes, other objects and turned floors, at several rates;
and rings.
"""

from __future__ import annotations

from collections.abc import Iterator

from halfphysics.base import rotations as rot
from support.spins import SHAPES, ring_spin, spin_of

FLOORS = ("plane", "box", "mesh", "object")
#: Sizes [m], each with frame rates and substeps; None: the fewest.
SIZES = {
    0.01: ((480, 1), (960, 1)),
    0.03: ((120, None), (240, 2)),
    0.2: ((30, None), (60, None), (240, 1)),
    2.0: ((30, None), (60, 1), (120, 1)),
}
YAWS = (0.0, 0.4, 0.785)
TURNS = ((0.5, -0.3, 0.2), (0.0, 1.2, 0.0))
#: Outer and inner radius of rings [m].
RINGS = ((0.2, 0.15), (0.2, 0.1), (0.2, 0.05))


def spins() -> Iterator[tuple[str, str, float, float]]:
    """Shape, floor, size [m], and the ratio that is farthest from 1."""
    for name in SHAPES:
        for on in FLOORS:
            for size, steps in SIZES.items():
                ratios = [
                    spin_of(name, on=on, size=size, fps=fps, substeps=substeps, yaw=yaw)
                    for fps, substeps in steps
                    for yaw in YAWS
                ]
                yield name, on, size, max(ratios, key=lambda r: abs(r - 1.0))
        ratios = [spin_of(name, turn=rot.exp(turn)) for turn in TURNS]
        yield name, "turned plane", 0.2, max(ratios, key=lambda r: abs(r - 1.0))


def main() -> None:
    """Prints the campaign's rows."""
    for name, on, size, ratio in spins():
        print(f"{name} on {on}, {size:g} m: {ratio:.3f}", flush=True)
    for outer, inner in RINGS:
        print(
            f"ring of pieces, {outer:g} and {inner:g} m: {ring_spin(outer, inner):.3f}", flush=True
        )


if __name__ == "__main__":
    main()
