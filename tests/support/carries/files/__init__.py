"""Recordings as files of data sets, one module per layout.

Every `write(made, folder)` writes a recording at the rate of its layout below a folder, with the
meshes and all that the data set has of the person, and returns a `Written`.
"""

from __future__ import annotations

from support.carries.files import arctic, behave, core4d, grab, intermimic, omomo

#: Layout -> its module, and the frame rate of its files [1/s].
LAYOUTS = {
    "omomo": (omomo, 30.0),
    "intermimic": (intermimic, 30.0),
    "grab": (grab, 120.0),
    "behave": (behave, 30.0),
    "arctic": (arctic, 30.0),
    "core4d": (core4d, 15.0),
}
