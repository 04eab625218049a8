"""Settings that follow a motion as it is: for tests of what weight, waiting and limits build on."""

from __future__ import annotations

from typing import Any

from halfphysics.settings import AS_IT_IS, Settings


def as_it_is(**changes: Any) -> Settings:
    """The default, but nobody has weight, waits, walks back or has limits; and these changes."""
    return Settings(**{**AS_IT_IS, **changes})
