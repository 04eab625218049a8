"""Clothes: a skin cut into shirt, trousers, shoes, hair and bare skin, to read as a person.

Each border is a plane in the rest pose (y up, z forward, x to the body's left), across a limb or
the trunk. Only names of joints and skinning weights are used: any body has clothes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.render.cutting import Cut, cut
from halfphysics.render.look import HAIR, PEOPLE, SHOES, SKIN, TROUSERS, Color

Array = NDArray[np.float64]

# Where a sleeve ends, from the shoulder to the elbow.
_SLEEVE = 0.55
# Where a trouser leg ends, above the ankle, and where trousers begin, from the pelvis to spine2:
# shares of the shin and of that distance.
_HEM, _WAIST = 0.10, 0.36
# Where the neck begins, from the neck's joint to the head's, in front and behind: the plane leans.
_COLLAR, _LEAN = 0.18, 0.55
# Hair: above a plane that leans back, over the head's joint by this share of the neck.
_CROWN, _BACK = 0.42, 1.15
# A vertex belongs to a limb if the limb's joints have at least this weight.
_OWN = 0.5
# Field of a vertex that is far from a border [m]: further than any that an edge may cross.
_FAR = 1.0
_HEAD = ("neck", "head", "jaw", "left_eye_smplhf", "right_eye_smplhf")


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A part of the skin with one colour.

    Attributes:
        name: "shirt", "trousers", "skin", "shoes" or "hair".
        color: Its colour.
        cut: Its vertices and faces, from those of the body.
    """

    name: str
    color: Color
    cut: Cut


def dressed(body: Body, person: int = 0) -> list[Piece]:
    """The pieces of a body's skin, without empty ones; together they are the whole skin.

    Args:
        body: The body.
        person: Index of the person, which decides the shirt.
    """
    colors = {"shirt": PEOPLE[person % len(PEOPLE)], "trousers": TROUSERS}
    colors |= {"skin": SKIN, "shoes": SHOES, "hair": HAIR}
    return [Piece(name=name, color=colors[name], cut=part) for name, part in _cuts(body)]


@lru_cache(maxsize=32)
def _cuts(body: Body) -> tuple[tuple[str, Cut], ...]:
    """Name and cut of each piece."""
    bare = np.maximum(_sleeves(body), _collar(body))
    hair, shoes, waist = _hair(body), _shoes(body), _waist(body)
    fields = {
        "shirt": np.minimum.reduce([-bare, -hair, waist]),
        "trousers": np.minimum.reduce([-bare, -waist, -shoes]),
        "skin": np.minimum(bare, -hair),
        "shoes": shoes,
        "hair": hair,
    }
    parts = ((name, cut(field, body.faces)) for name, field in fields.items())
    return tuple((name, part) for name, part in parts if len(part.faces))


def _share(body: Body, *names: str) -> Array:
    """Sum of the weights of joints at each vertex (V,)."""
    result: Array = np.asarray(body.weights)[:, [JOINT_INDEX[n] for n in names]].sum(axis=1)
    return result


def _along(body: Body, start: str, end: str) -> tuple[Array, float]:
    """Distance of each vertex from a joint towards another (V,), and that of the other [m]."""
    rest = np.asarray(body.rest_joints)
    origin = rest[JOINT_INDEX[start]]
    axis = rest[JOINT_INDEX[end]] - origin
    length = float(np.linalg.norm(axis))
    # Degenerate bodies may have joints in one place.
    return (np.asarray(body.rest_vertices) - origin) @ (axis / max(length, 1e-9)), length


def _arm(body: Body, side: str) -> Array:
    names = [n for n in JOINT_NAMES if n.startswith(f"{side}_") and n[len(side) + 1 :] in _ARM]
    return _share(body, *names)


_ARM = {"shoulder", "elbow", "wrist"} | {
    f"{finger}{k}" for finger in ("index", "middle", "pinky", "ring", "thumb") for k in (1, 2, 3)
}


def _sleeves(body: Body) -> Array:
    """Not negative on the arms beyond the sleeves."""
    fields = []
    for side in ("left", "right"):
        along, length = _along(body, f"{side}_shoulder", f"{side}_elbow")
        fields.append(np.where(_arm(body, side) >= _OWN, along - _SLEEVE * length, -_FAR))
    return np.maximum(*fields)


def _arms(body: Body) -> Array:
    return _arm(body, "left") + _arm(body, "right")


def _waist(body: Body) -> Array:
    """Not negative above the waist."""
    along, length = _along(body, "pelvis", "spine2")
    return np.where(_arms(body) >= _OWN, _FAR, along - _WAIST * length)


def _shoes(body: Body) -> Array:
    """Not negative on the feet."""
    fields = []
    for side in ("left", "right"):
        along, length = _along(body, f"{side}_knee", f"{side}_ankle")
        leg = _share(body, f"{side}_knee", f"{side}_ankle", f"{side}_foot")
        fields.append(np.where(leg >= _OWN, along - (1.0 - _HEM) * length, -_FAR))
    return np.maximum(*fields)


def _collar(body: Body) -> Array:
    """Not negative on the neck and the head."""
    along, length = _leaning(body, "neck", _LEAN)
    return np.where(_arms(body) >= _OWN, -_FAR, along - _COLLAR * length)


def _hair(body: Body) -> Array:
    """Not negative on the top and the back of the head."""
    along, length = _leaning(body, "head", -_BACK)
    return np.where(_share(body, *_HEAD) >= _OWN, along - _CROWN * length, -_FAR)


def _leaning(body: Body, joint: str, lean: float) -> tuple[Array, float]:
    """Distance of vertices from a joint, up and forwards by `lean` (V,); the neck's length."""
    rest = np.asarray(body.rest_joints)
    length = float(np.linalg.norm(rest[JOINT_INDEX["head"]] - rest[JOINT_INDEX["neck"]]))
    axis = np.array([0.0, 1.0, lean]) / np.hypot(1.0, lean)
    return (np.asarray(body.rest_vertices) - rest[JOINT_INDEX[joint]]) @ axis, length
