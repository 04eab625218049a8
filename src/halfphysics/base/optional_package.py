"""Packages that are not installed with this one: imported late, with one message if missing."""

from __future__ import annotations

import importlib
from typing import Any

from halfphysics.errors import MissingDependencyError


def optional(module: str, what: str, extra: str) -> Any:
    """The module, imported now.

    Args:
        module: Its name, such as "matplotlib.pyplot".
        what: What needs it, to begin the message with: "plots".
        extra: Extra of halfphysics that installs it.

    Raises:
        MissingDependencyError: It is not installed, or cannot be imported.
    """
    package = module.split(".")[0]
    try:
        importlib.import_module(package)
        return importlib.import_module(module)
    except ImportError as error:
        found = "" if getattr(error, "name", package) == package else f" (it failed: {error})"
        raise MissingDependencyError(
            f"{what} need {package}{found}: pip install 'halfphysics[{extra}]' "
            f"(or pip install {package})"
        ) from error
