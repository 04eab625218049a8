"""AMASS npz, SMPL-X layout: `poses (T, 165)` in `JOINT_NAMES` order.

It also reads body-only files (T, 66), which may need `model=`.
"""

from __future__ import annotations

from halfphysics.formats.amass.layout import Layout

LAYOUT = Layout(
    name="amass-smplx",
    width=165,
    fps_key="mocap_frame_rate",
    also=(66,),
    about="AMASS and what is written like it: SMPL-X",
)
FORMAT = LAYOUT.format
