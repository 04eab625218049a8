"""AMASS npz, SMPL layout: `poses (T, 72)` = root, body 21 and two rigid hands.

SMPL-X has no joints for the rigid hands: they are kept only to be written back.
"""

from __future__ import annotations

from halfphysics.formats.amass.layout import Layout

LAYOUT = Layout(
    name="amass-smpl",
    width=72,
    fps_key="mocap_framerate",
    about="AMASS and what is written like it: SMPL",
    invents="fingers",
)
FORMAT = LAYOUT.format
