"""The error of a message that does not follow its protocol."""

from __future__ import annotations

from halfphysics.errors import InputError


class Malformed(InputError):
    """A message is not what its protocol says; receivers count it and go on."""
