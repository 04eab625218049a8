"""Every scenario's contact labels against other libraries, at full length: the measured numbers.

    PYTHONPATH=tests python -m campaigns.labels [NAME ...]

All scenarios take about two minutes.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import halfphysics as hp
from halfphysics.labels import contact_labels
from support.judges.labels_judge import judge


def main(names):
    total, gaps = np.zeros(7, dtype=int), []
    farthest = 0.0
    print(
        "scenario: vertices of skin and objects, farthest [mm], missed; impulses, those without a"
    )
    print("those with a vertex's label; time of labels, also as share of simulating")
    for name in names:
        told = hp.scenarios.load(name)
        start = time.process_time()
        result = hp.simulate(
            list(told.motions), told.scene, body=list(told.bodies), settings=told.settings
        )
        middle = time.process_time()
        labels = contact_labels(result)
        end = time.process_time()
        v = judge(result, labels, most=400)
        row = [v.vertices, v.points, v.unlabelled, v.impulses, v.bare, v.with_vertex, v.between]
        total += row
        farthest = max(farthest, v.farthest)
        gaps.append(v.gaps)
        share = 100.0 * (end - middle) / (middle - start)
        frames = len(result.people[0].motion)
        each, whole = 1e3 * (end - middle) / frames, 1e3 * (middle - start) / frames
        print(
            f"{name:24} {row[0]:5} {row[1]:6} {1e3 * v.farthest:8.4f} {row[2]:3}; {row[3]:5} "
            f"{row[4]:3} {row[5]:5} ({100.0 * row[5] / max(row[3] - row[6], 1):5.1f} %); "
            f"{each:.3f} of {whole:.3f} ms a frame, {share:.1f} %",
            flush=True,
        )
        assert v.farthest <= labels.threshold_m + 1e-6, name
        assert v.unlabelled == 0, name
        assert v.bare == 0, name
    gaps = np.concatenate(gaps)
    print(f"all: {total[0]} skin and {total[1]} object vertices, farthest {1e3 * farthest:.4f} mm")
    print(f"missed {total[2]}; impulses {total[3]}, without a part's label {total[4]}")
    asked = total[3] - total[6]
    print(f"with a vertex's label {total[5]} of {asked} ({100.0 * total[5] / asked:.2f} %)")
    finite = gaps[np.isfinite(gaps)]
    print(f"the other {len(gaps)}: gap at the frame over the threshold in {(gaps > 2e-3).sum()}")
    for q in (0.5, 0.9, 1.0):
        print(f"  quantile {q}: {1e3 * np.quantile(finite, q):.3f} mm" if len(finite) else "")


if __name__ == "__main__":
    main(sys.argv[1:] or hp.scenarios.names())
