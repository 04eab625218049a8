"""Damaged copies of recorded clips, put right: what is left of each damage.

    PYTHONPATH=src:tests python -m campaigns.fix [--only walk] [--smooth 6]

Each clip is first put right itself: what comes out is the clean clip. It must come back as it is;
its copies, sunk by 3 cm, floating by 5 cm, drifting down by 2 cm/s, tilted by 2 degrees, with 5 mm
of noise, and sliding by 10 cm/s, must come back near it. Printed are PhysDiff's physical error, its
parts (penetrate + float + skate) and the distance of the joints from the clean clip (MPJPE, of the
pelvis and in the world [mm]), damaged and put right.

The error falls in two readings. The whole error of a copy cannot fall below what the clean clip
itself has, in jumps (float) and feet in the air (skate): so it can fall by `most` times where
nothing but the damage is taken off. The excess is the error over the clean clip's own; under 0.1 mm
counts as 0.1 mm.
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

#: An error over the clean clip's own that is less than this is none [mm].
NONE = 0.1


@dataclass(frozen=True)
class Row:
    """One copy: penetrate, float and skate, MPJPE, MPJPE in the world, each damaged and put right
    [mm]; and the physical error of the clean clip [mm]."""

    clip: str
    damage: str
    parts: tuple[tuple[float, float, float], tuple[float, float, float]]
    posed: tuple[float, float]
    moved: tuple[float, float]
    done: tuple[str, ...]
    clean: float

    @property
    def error(self) -> tuple[float, float]:
        """Physical error, damaged and put right [mm]."""
        return sum(self.parts[0]), sum(self.parts[1])

    @property
    def falls(self) -> float:
        """By how many times the physical error falls."""
        return self.error[0] / max(self.error[1], 1e-9)

    @property
    def most(self) -> float:
        """By how many times it falls where the clean clip comes back."""
        return self.error[0] / max(self.clean, 1e-9)

    @property
    def excess(self) -> float:
        """By how many times the error over the clean clip's own falls; nan: there was none."""
        before, after = (error - self.clean for error in self.error)
        return before / max(after, NONE) if before > NONE else float("nan")


def rows(name: str, body: hp.Body, smooth: float | None = None) -> list[Row]:
    """The clean copy and every damaged one of a clip."""
    clean = hp.fix(real_clip(name), body=body).motion
    own = sum(_parts(clean, body))
    found = []
    for damage, make in {"clean": lambda motion, body: motion, **DAMAGES}.items():
        bad = make(clean, body)
        made = hp.fix(bad, body=body, smooth=smooth if damage == "noisy" else None)
        both = (bad, made.motion)
        found.append(
            Row(
                name,
                damage,
                tuple(_parts(m, body) for m in both),
                tuple(metrics.mpjpe(m, clean, body) for m in both),
                tuple(metrics.mpjpe_global(m, clean, body) for m in both),
                made.done,
                own,
            )
        )
    return found


def _parts(motion: hp.Motion, body: hp.Body) -> tuple[float, float, float]:
    found = metrics.physdiff(motion, body)
    return found.penetrate_mm, found.float_mm, found.skate_mm


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
            print(
                f"{row.clip:28s} {row.damage:9s} {numbers}  {row.falls:5.1f} times (most "
                f"{row.most:.1f}), excess {row.excess:.1f} times",
                flush=True,
            )
            before, after = (" + ".join(f"{x:.2f}" for x in parts) for parts in row.parts)
            print(f"    {before} -> {after}; {'; '.join(row.done) or 'as it came'}")
    for line in summary(every):
        print(line)
    return 0


def summary(every: list[Row]) -> list[str]:
    """Of each damage: medians over the clips, and how many keep the goals."""
    lines = []
    for damage in dict.fromkeys(row.damage for row in every):
        its = [row for row in every if row.damage == damage]
        added, left = (np.median([row.error[k] - row.clean for row in its]) for k in (0, 1))
        excess = np.array([row.excess for row in its])
        known = excess[np.isfinite(excess)]
        moved = [np.median([row.moved[k] for row in its]) for k in (0, 1)]
        lines.append(
            f"{damage:9s} medians: error {np.median([row.falls for row in its]):.1f} times less "
            f"(most {np.median([row.most for row in its]):.1f}), over the clean clip's {added:.1f} "
            f"-> {left:.1f} mm, {np.median(known) if len(known) else np.nan:.1f} times less; "
            f"joints in the world {moved[0]:.1f} -> {moved[1]:.1f} mm; 10 times less in "
            f"{sum(row.falls >= 10.0 for row in its)} of {len(its)} (could be in "
            f"{sum(row.most >= 10.0 for row in its)}), excess in {(known >= 10.0).sum()} of "
            f"{len(known)}, MPJPE at most 10 mm over the damage's in "
            f"{sum(row.posed[1] <= row.posed[0] + 10.0 for row in its)}"
        )
    return lines


if __name__ == "__main__":
    sys.exit(main())
