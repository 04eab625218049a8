"""The folder of what is kept for the next process; it may be deleted at any time.

$HALFPHYSICS_CACHE, else $XDG_CACHE_HOME/halfphysics, else ~/.cache/halfphysics. With
HALFPHYSICS_CACHE=off nothing is kept.
"""

from __future__ import annotations

import os
from pathlib import Path

#: The value of $HALFPHYSICS_CACHE that switches caches off.
OFF = "off"


def cache_folder() -> Path | None:
    """The folder, which need not exist; None: nothing is kept."""
    own, xdg = os.environ.get("HALFPHYSICS_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if own:
        return None if own == OFF else Path(own)
    try:
        return (Path(xdg) if xdg else Path.home() / ".cache") / "halfphysics"
    except RuntimeError:  # this user has no home
        return None
