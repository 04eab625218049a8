"""Animations of a glTF file: keys of nodes' translations, rotations and scales over time.

Between keys values are interpolated linearly (rotations along the shortest arc, at even speed),
held (STEP), or cubic: with t from 0 to 1 over the d seconds between keys of values p, q and
tangents out of the first a and into the second b,

    (2 t^3 - 3 t^2 + 1) p + d (t^3 - 2 t^2 + t) a + (-2 t^3 + 3 t^2) q + d (t^3 - t^2) b

(glTF 2.0, appendix C.5). Before the first key and after the last the value is theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import shown
from halfphysics.formats.gltf.accessors import rows
from halfphysics.formats.gltf.container import Container, is_index
from halfphysics.formats.gltf.nodes import PATHS

Array = NDArray[np.float64]

#: Times of keys, in single precision, are off by less than this [s] and this part of them.
_TICK, _SINGLE = 1e-7, 1.2e-7
#: Times and the grid of a rate differ by less than this part of a step: single precision.
_ON_GRID = 0.02
#: Steps whose longest is within this factor of the shortest are even, but for rounding.
_EVEN = 1.5
#: Rates that differ by less than this part are the same.
_SAME_RATE = 2e-4
#: A clip with keys at a rate outside of these was made by hand: between keys there is movement.
_RATES = (10.0, 1000.0)
#: Clips of one file: far above any library of moves.
_MOST_CLIPS = 1_000
#: The rate at which clips are read whose keys have none.
SAMPLED = 30.0


@dataclass(frozen=True, eq=False)
class Keys:
    """Keys of one property of a node: times (K,) [s], values (K, n), and how to interpolate them.

    Cubic ones have tangents into and out of each key, (K, n) each, per second.
    """

    times: Array
    values: Array
    kind: str
    tangents: tuple[Array, Array] | None = None

    def at(self, times: Array, *, turns: bool) -> Array:
        """The values (T, n) at times (T,); quaternions (`turns`) stay of length one."""
        keys = self.times
        if len(keys) == 1:
            return np.repeat(self.values, len(times), axis=0)
        # A frame is not before the key that is meant for it, whose time is in single precision.
        times = times + _TICK + _SINGLE * times
        low = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
        gap = keys[low + 1] - keys[low]
        part = np.clip((times - keys[low]) / gap, 0.0, 1.0)[:, None]
        first, second = self.values[low], self.values[low + 1]
        if self.kind == "STEP":
            return np.where(part < 1.0, first, second)
        if self.tangents is not None:
            into, out = self.tangents
            a, b = gap[:, None] * out[low], gap[:, None] * into[low + 1]
            square, cube = part**2, part**3
            value = (2 * cube - 3 * square + 1) * first + (cube - 2 * square + part) * a
            value += (-2 * cube + 3 * square) * second + (cube - square) * b
        elif turns:
            return np.asarray(rot.slerp(first, second, part[:, 0]))
        else:
            value = first + part * (second - first)
        return np.asarray(rot.normalize(value) if turns else value)


def animations(container: Container, nodes: int) -> list[Animation]:
    """The animations of a file that move any of its `nodes` nodes.

    Raises:
        FileError: As `Animation`, and over 1,000 of them.
    """
    count = len(container.entries("animations"))
    if count > _MOST_CLIPS:
        raise container.error(f"found {count} animations, expected at most {_MOST_CLIPS}")
    found = [Animation(container, index, nodes) for index in range(count)]
    return [animation for animation in found if animation.keys]


class Animation:
    """One animation: the keys of nodes by node and path.

    Raises:
        FileError: A channel has no keys, times that do not increase, or the wrong number of values.
    """

    def __init__(self, container: Container, index: int, nodes: int) -> None:
        self._container = container
        entry = container.entry("animations", index)
        self.name = entry["name"] if isinstance(entry.get("name"), str) else f"animation {index}"
        self._where = f"animation {self.name!r}"
        self._samplers = entry.get("samplers", [])
        channels = entry.get("channels", [])
        if not isinstance(self._samplers, list) or not isinstance(channels, list):
            raise container.error(f"{self._where}: expected lists of samplers and channels")
        extras = entry.get("extras")
        self._said = extras.get("fps") if isinstance(extras, dict) else None
        self._times: dict[Any, Array] = {}
        self.keys: dict[tuple[int, str], Keys] = {}
        for number, channel in enumerate(channels):
            target = channel.get("target") if isinstance(channel, dict) else None
            if not isinstance(target, dict):
                raise container.error(f"{self._where}: channel {number} has no target")
            node, path = target.get("node"), target.get("path")
            if node is None or not isinstance(path, str) or path not in PATHS:
                continue  # weights of morph targets, and targets of extensions
            if not is_index(node, nodes):
                raise container.error(f"{self._where}: channel {number}: no node {shown(node)}")
            self.keys[node, path] = self._read(number, channel.get("sampler"), path)

    def _read(self, number: int, index: Any, path: str) -> Keys:
        what = f"{self._where}, channel {number} ({path})"
        found = self._samplers[index] if is_index(index, len(self._samplers)) else None
        if not isinstance(found, dict):
            raise self._container.error(f"{what}: no sampler {shown(index)}")
        kind = found.get("interpolation", "LINEAR")
        if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
            raise self._container.error(
                f"{what}: interpolation: found {shown(kind)}, expected LINEAR, STEP or CUBICSPLINE"
            )
        source = found.get("input")
        if source not in self._times if isinstance(source, int) else True:
            times = rows(self._container, source, "SCALAR", f"{what}, times")[:, 0]
            if (np.diff(times) <= 0.0).any() or times[0] < 0.0:
                raise self._container.error(f"{what}: times do not increase, expected each once")
            self._times[source] = times
        times = self._times[source]
        type = "VEC4" if path == "rotation" else "VEC3"
        values = rows(self._container, found.get("output"), type, f"{what}, values")
        expected = len(times) * (3 if kind == "CUBICSPLINE" else 1)
        if len(values) != expected:
            raise self._container.error(
                f"{what}: found {len(values)} values, expected {expected} for {len(times)} times"
            )
        if path == "rotation":
            values = values[:, [3, 0, 1, 2]]
        tangents = None
        if kind == "CUBICSPLINE":
            into, values, out = (values[k::3] for k in range(3))
            tangents = into, out
        if path == "rotation":
            if (np.linalg.norm(values, axis=1) < 0.5).any():
                raise self._container.error(f"{what}: quaternions of no length")
            if kind != "CUBICSPLINE":
                values = rot.normalize(values)
        return Keys(times, values, kind, tangents)

    def span(self, nodes: set[int]) -> tuple[float, float]:
        """The first and the last time [s] of the keys of some nodes."""
        times = [keys.times for (node, _), keys in self.keys.items() if node in nodes]
        return min(float(t[0]) for t in times), max(float(t[-1]) for t in times)

    def rate(self, nodes: set[int]) -> float | None:
        """Keys per second of some nodes, if they are at even steps; else None.

        What the file says (`extras.fps`, of files written here), else the steps of the node with
        most keys, if all keys are on their grid.
        """
        said = self._said
        if isinstance(said, int | float) and not isinstance(said, bool) and 0.0 < said < 1e4:
            return float(said)
        found = {id(k.times): k.times for (n, _), k in self.keys.items() if n in nodes}
        most = max(found.values(), key=len)
        if len(most) < 2:
            return None
        steps = np.diff(most)
        even = steps.max() < _EVEN * steps.min()
        step = float((most[-1] - most[0]) / (len(most) - 1)) if even else float(steps.min())
        for times in found.values():
            places = (times - most[0]) / step
            if np.abs(places - np.round(places)).max() > _ON_GRID + 1e-6 * len(most):
                return None
        rate = 1.0 / step
        for whole in (round(rate), round(1.001 * rate) / 1.001):
            if whole > 0 and abs(whole - rate) < _SAME_RATE * rate:
                rate = float(whole)
                break
        return rate if _RATES[0] <= rate <= _RATES[1] else None
