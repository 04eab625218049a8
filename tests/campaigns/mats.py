"""The campaign behind `campaigns/test_mats.py`: walks over mats, and who stands on them.

    PYTHONPATH=src:tests python -m campaigns.mats [--only walks] [--fps 60]

Prints one row of figures a walk (`support.mats.Crossing`), and one a standing person: how far the
soles sink and how much of the weight the layer carries, at frame rates and substeps.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict

import halfphysics as hp
from support.mats import Crossing, crossed, crossing, forces, soles, stood

#: Materials and thicknesses [m] that are walked over, and stood on.
WALKS = (
    ("mat", 0.02),
    ("mat", 0.05),
    ("mat", 0.10),
    ("mat", 0.20),
    ("mattress", 0.05),
    ("mattress", 0.10),
    ("mattress", 0.20),
)
STOOD_ON = (("mattress", 0.20), ("mat", 0.10))
#: Frame rates and substeps a frame.
STEPS = ((30.0, 4), (30.0, 8), (30.0, 16), (60.0, 4), (60.0, 8), (60.0, 16), (120.0, 4), (120.0, 8))


def walks(body: hp.Body, fps: float = 30.0) -> Iterator[tuple[str, float, Crossing]]:
    """Every walk, and its figures."""
    for material, thickness in WALKS:
        yield material, thickness, crossing(crossed(body, material, thickness, fps), thickness)


def sinks(
    body: hp.Body, material: str, thickness: float
) -> Iterator[tuple[float, int, float, float]]:
    """Frame rate, substeps, depth of the deeper sole [m] and share of the weight carried."""
    for fps, substeps in STEPS:
        result = stood(body, material, thickness, fps, substeps)
        depth = thickness - soles(result)[1][-1].min()
        yield fps, substeps, depth, forces(result)[-round(0.2 * fps) :, 2].mean()


def main() -> None:
    """Prints the campaign's rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=("walks", "stands"), help="a part of it")
    parser.add_argument("--fps", type=float, default=30.0, help="frame rate of the walks [Hz]")
    args = parser.parse_args()
    body = hp.Body.default()
    if args.only != "stands":
        for material, thickness, figures in walks(body, args.fps):
            shown = ", ".join(f"{name} {value:.3f}" for name, value in asdict(figures).items())
            print(f"walk {material} {thickness:.2f} m: {shown}", flush=True)
    if args.only != "walks":
        for material, thickness in STOOD_ON:
            for fps, substeps, depth, share in sinks(body, material, thickness):
                row = (
                    f"{fps:.0f} fps N {substeps}: depth {1000 * depth:.2f} mm, carried {share:.4f}"
                )
                print(f"stand {material} {thickness:.2f} m: {row}", flush=True)


if __name__ == "__main__":
    main()
