"""The one family of exceptions: catch `HalfPhysicsError` and nothing else is needed.

Messages say what was found, what was expected and the way out.
"""

from __future__ import annotations


class HalfPhysicsError(Exception):
    """Base of all errors that halfphysics raises on purpose."""


class InputError(HalfPhysicsError, ValueError):
    """A value the caller gave is impossible (shape, unit, NaN, sign, unknown name)."""


class FileError(HalfPhysicsError):
    """A file is missing, unreadable, of another format than expected, or unsafe to read."""


class MismatchError(HalfPhysicsError):
    """A motion and a body that do not belong together (gender or model differ)."""


class MissingDependencyError(HalfPhysicsError, ImportError):
    """An optional package is needed for this and is not installed."""


class HalfPhysicsWarning(UserWarning):
    """Something worth knowing that does not stop the work (unused betas, sunken start)."""
