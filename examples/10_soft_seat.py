"""A person sits down on a thin pad and on a sofa: the pressures on the skin.

Run it: python examples/10_soft_seat.py
"""

from __future__ import annotations

from typing import Any

import halfphysics as hp
from halfphysics.results.layer_pressure import carried_share, pressures

#: What covers the seat: name -> layer.
SEATS: dict[str, Any] = {
    "pad of 4 cm": hp.Soft(thickness=0.04, stiffness=4e5),
    "sofa": "sofa",
}


def sit(layer: Any) -> hp.Result:
    """The person of the scenario sits down on a seat with a layer."""
    story = hp.scenarios.load("sit_on_sofa")
    scene = hp.Scene()
    for name, item in story.scene.statics.items():
        soft = layer if name == "seat" else None
        scene.add_static(name, item.shape, position=item.position, soft=soft)
    return hp.simulate(story.motion, scene, body=story.body, settings=story.settings)


def main() -> dict[str, tuple[float, float, float]]:
    """Seat -> peak pressure [kPa], largest area [cm^2], largest share of the weight."""
    found = {}
    for seat, layer in SEATS.items():
        result = sit(layer)
        its = max(pressures(result), key=lambda pair: pair.peak.max())
        peak, area = 1e-3 * its.peak.max(), 1e4 * its.area.max()
        share = carried_share(result, 0).max()
        found[seat] = float(peak), float(area), float(share)
        print(f"{seat}: up to {peak:.1f} kPa, {area:.0f} cm², {100 * share:.0f} % of the weight")
    return found


if __name__ == "__main__":
    main()
