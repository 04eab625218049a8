"""Outputs of a sweep: contact labels, the output folder and the division into shards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError

FORMATS = ("webdataset", "hdf5")
#: Data sets whose label layouts and thresholds are available.
ALSO = ("behave", "omomo", "chois", "arctic")


@dataclass(frozen=True, kw_only=True)
class Labels:
    """How contact is labelled.

    Attributes:
        threshold: A vertex up to this distance from an object touches it [m]; None: clearance
            plus 1 mm.
        also: Data sets whose labels are written too, at their own thresholds.
    """

    threshold: float | None = None
    also: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.threshold is not None:
            number(self.threshold, "threshold", above=0.0, unit="m")
        object.__setattr__(self, "also", _names(self.also, "also", ALSO))

    def document(self) -> dict[str, Any]:
        """The options as plain data."""
        return {"threshold": self.threshold, "also": list(self.also)}


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """The output folder, the formats and the division into shards.

    Attributes:
        folder: Output folder, relative to the plan's folder.
        formats: "webdataset" (tar), "hdf5", or both.
        variants_per_shard: Variants in a shard, rounded up to whole batches.
        batch: Consecutive variants that are computed and written together.
        results: Whether each sample also has the whole result (result.npz).
        support: Whether each sample also has what holds people up (support.npz).
    """

    folder: str = "sweep"
    formats: tuple[str, ...] = ("webdataset",)
    variants_per_shard: int = 1000
    batch: int = 8
    results: bool = False
    support: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.folder, str) or not self.folder:
            raise InputError(f"folder: found {shown(self.folder)}, expected the path of a folder")
        object.__setattr__(self, "formats", _names(self.formats, "formats", FORMATS))
        if not self.formats:
            raise InputError(f"formats: found none, expected {' or '.join(FORMATS)}, or both")
        for name in ("variants_per_shard", "batch"):
            value = getattr(self, name)
            if not is_whole(value, least=1):
                raise InputError(
                    f"{name}: found {shown(value)}, expected a whole number of at least 1"
                )
        for name in ("results", "support"):
            value = getattr(self, name)
            if not isinstance(value, bool):
                raise InputError(f"{name}: found {shown(value)}, expected true or false")

    def document(self) -> dict[str, Any]:
        """The options as plain data."""
        return {
            "folder": self.folder,
            "formats": list(self.formats),
            "variants_per_shard": self.variants_per_shard,
            "batch": self.batch,
            "results": self.results,
            "support": self.support,
        }


def _names(value: Any, what: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Some of the known names, each once, in the order of `known`."""
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, list | tuple):
        raise InputError(f"{what}: found {shown(value)}, expected a list of {', '.join(known)}")
    for name in names:
        if name not in known:
            raise InputError(f"{what}: found {shown(name)}, expected some of {', '.join(known)}")
    return tuple(name for name in known if name in names)
