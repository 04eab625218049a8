"""Damaged copies of recorded clips, put right: what is left of each damage.

    PYTHONPATH=src:tests python -m campaigns.fix [--only walk] [--smooth 6]

Each clip is first put right itself: what comes out is the clean clip. It must come back as it is;
its copies, sunk by 3 cm, floating by 5 cm, drifting down by 2 cm/s, tilted by 2 degrees, with 5 mm
of noise, and sliding by 10 cm/s, must come back near it. Printed are PhysDiff's physical error and
the distance of the joints from the clean clip, damaged and put right (MPJPE, of the pelvis and in
the world [mm]).
"""

from __future__ import annotations

import argparse
import sys
import warnings
from dataclasses import dataclass

import numpy as np

import halfphysics as hp
from halfphysics import metrics
from support.damage import DAMAGES
from support.real_clips import NAMES, real_clip


@dataclass(frozen=True)
class Row:
    """One copy: physical error, MPJPE, MPJPE in the world, each damaged and put right [mm]."""

    clip: str
    damage: str
    error: tuple[float, float]
    posed: tuple[float, float]
    moved: tuple[float, float]
    done: tuple[str, ...]

    @property
    def falls(self) -> float:
        """By how many times the physical error falls."""
        return self.error[0] / max(self.error[1], 1e-9)


def rows(name: str, body: hp.Body, smooth: float | None = None) -> list[Row]:
    """The clean copy and every damaged one of a clip."""
    clean = hp.fix(real_clip(name), body=body).motion
    found = []
    for damage, make in {"clean": lambda motion, body: motion, **DAMAGES}.items():
        bad = make(clean, body)
        made = hp.fix(bad, body=body, smooth=smooth if damage == "noisy" else None)
        both = (bad, made.motion)
        found.append(
            Row(
                name,
                damage,
                tuple(metrics.physdiff(m, body).phys_err_mm for m in both),
                tuple(metrics.mpjpe(m, clean, body) for m in both),
                tuple(metrics.mpjpe_global(m, clean, body) for m in both),
                made.done,
            )
        )
    return found


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="part of the names of clips")
    parser.add_argument("--smooth", type=float, help="low pass for noisy copies [Hz]")
    options = parser.parse_args(argv)
    warnings.simplefilter("ignore", hp.HalfPhysicsWarning)
    body = hp.Body.default()
    every: list[Row] = []
    for name in NAMES:
        if options.only not in name:
            continue
        for row in rows(name, body, options.smooth):
            every.append(row)
            numbers = "  ".join(
                f"{what} {a:7.2f} -> {b:6.2f}"
                for what, (a, b) in (
                    ("error", row.error),
                    ("MPJPE", row.posed),
                    ("in the world", row.moved),
                )
            )
            print(f"{row.clip:28s} {row.damage:9s} {numbers}  {row.falls:5.1f} times", flush=True)
            print(f"    {'; '.join(row.done) or 'as it came'}")
    for line in summary(every):
        print(line)
    return 0


def summary(every: list[Row]) -> list[str]:
    """Of each damage: medians over the clips, and how many keep the goals."""
    clean = {row.clip: row.error[0] for row in every if row.damage == "clean"}
    lines = []
    for damage in dict.fromkeys(row.damage for row in every):
        its = [row for row in every if row.damage == damage]
        added = np.median([row.error[0] - clean[row.clip] for row in its])
        left = np.median([row.error[1] - clean[row.clip] for row in its])
        moved = [np.median([row.moved[k] for row in its]) for k in (0, 1)]
        lines.append(
            f"{damage:9s} medians: error {np.median([row.falls for row in its]):.1f} times less, "
            f"over the clean clip's {added:.1f} -> {left:.1f} mm, joints in the world "
            f"{moved[0]:.1f} -> {moved[1]:.1f} mm; error 10 times less in "
            f"{sum(row.falls >= 10.0 for row in its)} of {len(its)}, MPJPE at most 10 mm over the "
            f"damage's in {sum(row.posed[1] <= row.posed[0] + 10.0 for row in its)}"
        )
    return lines


if __name__ == "__main__":
    sys.exit(main())
