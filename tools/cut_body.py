"""Cut the skin of the default body beforehand, into `assets/body_cut.npz`: 0.4 s less at each start.

Run by hand after a change to `body.npz` or to `skin_cut.py`, with the package installed, and commit
what it wrote; `tests/body/test_skin_hulls.py` fails until then:

    python tools/cut_body.py

The file has one number for each face: which piece it is in. Any machine gives the same ones, and two
runs the same bytes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from halfphysics.body.body import Body
from halfphysics.body.skin_hulls import bake

OUT = Path(__file__).resolve().parents[1] / "src/halfphysics/assets/body_cut.npz"


def main() -> None:
    """Cut, write, say how large."""
    body = Body.default()
    found = bake(body.faces, body.weights, body.mean_vertices, body.mean_joints)
    np.savez_compressed(OUT, **found)
    print(f"{OUT}: {found['piece'].max() + 1} pieces, {OUT.stat().st_size} bytes")


if __name__ == "__main__":
    main()
