"""Items of a scene as one line of text each, for the command line.

``ball=sphere:0.11,mass=0.43,position=1:0:0.11``: a name, a shape with its sizes or the path of a
mesh, then key=value pairs; several numbers of one value are joined by colons.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from halfphysics.base.suggestions import did_you_mean
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Shape, Sphere
from halfphysics.scene.soft_materials import MATERIALS

#: Shape by its word: constructor from numbers, their count, form for messages.
_SHAPES: dict[str, tuple[Callable[[list[float]], Shape], int, str]] = {
    "plane": (lambda v: Plane(), 0, "plane"),
    "sphere": (lambda v: Sphere(*v), 1, "sphere:RADIUS"),
    "box": (lambda v: Box(v), 3, "box:X:Y:Z"),
    "capsule": (lambda v: Capsule(*v), 2, "capsule:RADIUS:LENGTH"),
    "cylinder": (lambda v: Cylinder(*v), 2, "cylinder:RADIUS:LENGTH"),
}

#: Key -> (argument of add_static / add_object, count of numbers; 0: text).
_STATIC = {
    "friction": ("friction", 1),
    "restitution": ("restitution", 1),
    "position": ("position", 3),
    "quaternion": ("quaternion", 4),
    "scale": ("scale", 1),
    "up": ("up", 0),
    "soft": ("soft", 0),
}
_OBJECT = {
    "mass": ("mass", 1),
    "density": ("density", 1),
    "velocity": ("velocity", 3),
    **_STATIC,
    "pieces": ("pieces", 0),
    "threshold": ("threshold", 1),
    "max_pieces": ("max_pieces", 1),
}

#: Shorter names of keys, which earlier versions had.
_SHORT = {"at": "position", "quat": "quaternion"}

#: Allowed values of the keys with text.
_WORDS = {"up": ("y", "z"), "pieces": ("auto", "hull"), "soft": tuple(MATERIALS)}

Parsed = tuple[str, Shape | str, dict[str, Any]]


def parse_object(text: str) -> Parsed:
    """(name, shape or mesh path, keyword arguments of `Scene.add_object`) of one line.

    Keys: mass, density, friction, restitution, position, quaternion, velocity, scale, up,
    soft, pieces, threshold, max_pieces. Raises one `InputError` that lists all mistakes.
    """
    return _parse(text, _OBJECT, "object", "ball=sphere:0.11,mass=0.43,position=1:0:0.11")


def parse_static(text: str) -> Parsed:
    """(name, shape or mesh path, keyword arguments of `Scene.add_static`) of one line.

    Keys: friction, restitution, position, quaternion, scale, up, soft. Raises one `InputError` that
    lists all mistakes.
    """
    return _parse(text, _STATIC, "static", "wall=box:0.1:2:2.5,position=1:0:1.25")


def _parse(text: str, keys: dict[str, tuple[str, int]], kind: str, example: str) -> Parsed:
    name, equals, rest = text.partition("=")
    problems: list[str] = []
    # In "sphere:0.11,mass=1" the first "=" is behind a comma or colon: the name is missing.
    if not equals or not name.strip() or "," in name or ":" in name:
        raise InputError(f"{kind} {text!r}: expected NAME=SHAPE, such as {example}")
    first, *pairs = rest.split(",")
    shape = _shape(first.strip(), problems)
    options: dict[str, Any] = {}
    for pair in pairs:
        key, equals, value = (part.strip() for part in pair.partition("="))
        known = _SHORT.get(key, key)
        if known not in keys:
            hint = did_you_mean(key, keys, brackets=True)
            problems.append(f"unknown key {key!r}{hint}, allowed: {', '.join(keys)}")
            continue
        argument, count = keys[known]
        if not equals or not value:
            problems.append(f"{key} has no value, expected {_form(key, count)}")
        elif argument in options:
            problems.append(f"{known} is given twice")
        elif count == 0:
            if value not in _WORDS[key]:
                problems.append(f"{key}: found {value!r}, expected {' or '.join(_WORDS[key])}")
            options[argument] = value
        else:
            numbers = _numbers(value.split(":"))
            if numbers is None or len(numbers) != count:
                problems.append(f"{key}: found {value!r}, expected {_form(key, count)}")
                continue
            options[argument] = numbers[0] if count == 1 else tuple(numbers)
    weights = [k for k in ("mass", "density") if k in (p.partition("=")[0].strip() for p in pairs)]
    if kind == "object" and len(weights) != 1:
        found = "both" if weights else "neither"
        problems.append(f"expected mass= [kg] or density= [kg/m^3], found {found}")
    if problems or shape is None:
        raise InputError(f"{kind} {text!r}: {'; '.join(problems)}. Example: {example}")
    return name.strip(), shape, options


def _form(key: str, count: int) -> str:
    if count == 0:
        return " or ".join(f"{key}={word}" for word in _WORDS[key])
    return f"{key}={':'.join(['NUMBER'] * count)}"


def _numbers(parts: list[str]) -> list[float] | None:
    try:
        values = [float(part) for part in parts]
    except ValueError:
        return None
    return values if all(map(math.isfinite, values)) else None


def _shape(text: str, problems: list[str]) -> Shape | str | None:
    word, *sizes = text.split(":")
    if word not in _SHAPES:
        suffix = Path(text).suffix
        if any(c.isalpha() for c in suffix) or os.path.exists(text):
            return text
        hint = did_you_mean(word, _SHAPES, brackets=True)
        forms = ", ".join(form for _, _, form in _SHAPES.values())
        problems.append(
            f"unknown shape {text!r}{hint}, expected {forms} or the path of a mesh file"
        )
        return None
    make, count, form = _SHAPES[word]
    numbers = _numbers(sizes)
    if numbers is None or len(numbers) != count:
        problems.append(f"shape {text!r}: expected {form}")
        return None
    try:
        return make(numbers)
    except InputError as error:
        problems.append(str(error))
        return None
