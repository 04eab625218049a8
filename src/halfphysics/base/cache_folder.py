"""The folder of what is kept for the next process; it may be deleted at any time.

$HALFPHYSICS_CACHE, else $XDG_CACHE_HOME/halfphysics, else what the platform prescribes:
~/Library/Caches/halfphysics (macOS), %LOCALAPPDATA%\\halfphysics\\Cache (Windows),
~/.cache/halfphysics. With HALFPHYSICS_CACHE=off nothing is kept.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

#: The value of $HALFPHYSICS_CACHE that switches caches off.
OFF = "off"


def cache_folder() -> Path | None:
    """The folder, which need not exist; None: nothing is kept."""
    own, xdg = os.environ.get("HALFPHYSICS_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if own:
        return None if own == OFF else Path(own)
    if xdg:
        return Path(xdg) / "halfphysics"
    local = os.environ.get("LOCALAPPDATA")
    if sys.platform == "win32" and local:
        return Path(local) / "halfphysics" / "Cache"
    try:
        home = Path.home()
        caches = home / "Library" / "Caches" if sys.platform == "darwin" else home / ".cache"
        return caches / "halfphysics"
    except RuntimeError:  # this user has no home
        return None
