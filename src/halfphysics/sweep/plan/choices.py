"""The choice of body and of scene: two axes of a sweep beside its inputs and factors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.sweep.plan.factors import STATURE

#: The name of the body or scene of the input itself.
OWN = "own"


@dataclass(frozen=True, kw_only=True)
class BodyChoice:
    """A body; without any field, the input's own body or else the default body.

    Attributes:
        stature: Height of the default body [m].
        model: A body model, a file or a folder of them, relative to the plan's folder.
        allow_mismatch: Take a model of another gender or kind than the motion's, with its mean
            shape.
        path: Path at which the model can be opened (of a variant; a plan may leave it out).
    """

    stature: float | None = None
    model: str | None = None
    allow_mismatch: bool = False
    path: Path | None = None

    def __post_init__(self) -> None:
        if self.stature is not None:
            STATURE.check("stature", self.stature)
        if self.model is not None and (not isinstance(self.model, str) or not self.model):
            raise InputError(f"model: found {shown(self.model)}, expected the path of a body model")
        if not isinstance(self.allow_mismatch, bool):
            raise InputError(
                f"allow_mismatch: found {shown(self.allow_mismatch)}, expected true or false"
            )
        if self.stature is not None and self.model is not None:
            raise InputError(
                "stature: is for the default body; the shape of a model comes from the motion's "
                "betas. Leave out stature or model"
            )
        if self.allow_mismatch and self.model is None:
            raise InputError("allow_mismatch: is for a model; add model, or leave it out")

    @property
    def name(self) -> str:
        """Its name in expressions and cards: "own", "stature=1.6" or the path given in the plan."""
        if self.stature is not None:
            return f"stature={float(self.stature)!r}"
        return self.model or OWN

    def document(self) -> Any:
        """The choice as plain data."""
        if self.stature is not None:
            return {"stature": self.stature}
        if self.model is not None:
            return {"model": self.model, "allow_mismatch": self.allow_mismatch}
        return OWN


@dataclass(frozen=True, kw_only=True)
class SceneChoice:
    """A scene: the scene file, or else the input's own scene.

    Attributes:
        file: A scene file, relative to the plan's folder.
        path: Path at which the file can be opened (of a variant; a plan may leave it out).
    """

    file: str | None = None
    path: Path | None = None

    def __post_init__(self) -> None:
        if self.file is not None and (not isinstance(self.file, str) or not self.file):
            raise InputError(f"scenes: found {shown(self.file)}, expected own or a scene file")

    @property
    def name(self) -> str:
        """Its name in expressions and cards: "own" or the path given in the plan."""
        return self.file or OWN

    def document(self) -> Any:
        """The choice as plain data."""
        return self.name
