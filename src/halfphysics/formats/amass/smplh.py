"""AMASS npz, SMPL-H layout: `poses (T, 156)` = root, body 21, left hand 15, right hand 15."""

from __future__ import annotations

from halfphysics.formats.amass.layout import Layout

LAYOUT = Layout(
    name="amass-smplh",
    width=156,
    fps_key="mocap_framerate",
    about="AMASS and what is written like it: SMPL-H",
)
FORMAT = LAYOUT.format
