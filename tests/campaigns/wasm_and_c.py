"""Long comparisons of the C library and of WebAssembly with Python's simulator.

    PYTHONPATH=src:tests python -m campaigns.wasm_and_c

The C example over 10,000 frames of the kick, and 300 frames of kick and lift by node: largest
differences, and speeds by processor time. Needs tools/build_inplace.sh (or tools/test_native.sh), a
C compiler and node.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from support.c_example import c_end, python_end
from support.wasm_core import by_wasm


def c_example(frames: int) -> float:
    """Largest difference of the C example's end from Python's [m, rad]."""
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        pose, ball = c_end(Path(folder), patch, frames)
    expected_pose, expected_ball = python_end(frames)
    return float(max(np.abs(pose - expected_pose).max(), np.abs(ball - expected_ball).max()))


def main() -> None:
    """Prints all figures."""
    for name in ("kick_ball", "lift_suitcase"):
        with tempfile.TemporaryDirectory() as folder:
            found, expected, said = by_wasm(Path(folder), name, slice(0, 301))
        speed, native = said["framesPerSecond"], said["native"]
        print(
            f"{name}: {len(found)} frames, max difference {np.abs(found - expected).max():.3g}, "
            f"{speed:.0f} frames/s by WebAssembly, {native:.0f} native: {speed / native:.2f}",
            flush=True,
        )
    print(f"C example: 10000 frames, max difference {c_example(10_000):.3g}")


if __name__ == "__main__":
    main()
