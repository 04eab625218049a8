"""Groups of joints, and numbers per joint given by group or name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, LEFT_HAND_JOINTS, N_JOINTS

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

_SIDES = ("left", "right")


def _groups() -> dict[str, tuple[str, ...]]:
    fingers = tuple(JOINT_NAMES[i].removeprefix("left_") for i in LEFT_HAND_JOINTS)
    limbs = {
        "fingers": fingers,
        "hand": ("wrist", *fingers),
        "arm": ("collar", "shoulder", "elbow", "wrist", *fingers),
        "foot": ("ankle", "foot"),
        "leg": ("hip", "knee", "ankle", "foot"),
    }
    plurals = {"hand": "hands", "arm": "arms", "foot": "feet", "leg": "legs"}
    groups: dict[str, tuple[str, ...]] = {}
    for limb, joints in limbs.items():
        sides = [tuple(f"{side}_{joint}" for joint in joints) for side in _SIDES]
        groups[plurals.get(limb, limb)] = sides[0] + sides[1]
        for side, names in zip(_SIDES, sides, strict=True):
            # "left_foot" is a joint (the toes'): the group of that name would hide it.
            if f"{side}_{limb}" not in JOINT_INDEX:
                groups[f"{side}_{limb}"] = names
    groups["trunk"] = ("spine1", "spine2", "spine3")
    groups["head"] = ("neck", "head", "jaw", "left_eye_smplhf", "right_eye_smplhf")
    groups["all"] = JOINT_NAMES[1:]
    return groups


#: Name -> joints. A limb's group includes its end: "arms" the hands, "legs" the feet. "head" is the
#: group, with the neck; the joint "head" has no key of its own.
JOINT_GROUPS: Mapping[str, tuple[str, ...]] = MappingProxyType(_groups())

#: The key of `Settings.strength` for the force on the root [N].
ROOT_FORCE = "root"


class JointValues(Mapping[str, float]):
    """Numbers by joint group or joint name, read-only and hashable.

    The smaller group of joints has precedence ("hands" over "arms", a joint over its group); of two
    groups of equal size, the later one.
    """

    __slots__ = ("_items",)
    _items: tuple[tuple[str, float], ...]

    def __init__(self, values: Mapping[str, float]) -> None:
        self._items = tuple((str(key), float(value)) for key, value in values.items())

    def __getitem__(self, key: str) -> float:
        return dict(self._items)[key]

    def __iter__(self) -> Iterator[str]:
        return (key for key, _ in self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __eq__(self, other: object) -> bool:
        # The order of two groups of equal size decides which has precedence.
        return isinstance(other, Mapping) and self._items == tuple(other.items())

    def __hash__(self) -> int:
        return hash(self._items)

    def __repr__(self) -> str:
        return repr(dict(self._items))

    def __reduce__(self) -> tuple[Any, ...]:
        return JointValues, (dict(self._items),)

    def resolve(self, default: float) -> Array:
        """The numbers of all joints (55,), in the order of `JOINT_NAMES`."""
        out = np.full(N_JOINTS, default)
        for key, value in sorted(self._items, key=lambda item: -len(_joints_of(item[0]))):
            for name in _joints_of(key):
                out[JOINT_INDEX[name]] = value
        return out


def _joints_of(key: str) -> tuple[str, ...]:
    return JOINT_GROUPS.get(key, (key,) if key in JOINT_INDEX else ())


def joint_values(
    value: Any, what: str, *, extra: tuple[str, ...] = (), unit: str = ""
) -> JointValues:
    """`value`, a mapping from joint groups or names to numbers >= 0, checked.

    Args:
        value: The mapping.
        what: Its purpose, with which messages begin.
        extra: Allowed keys besides joints and groups.
        unit: Unit of the numbers, for messages.

    Raises:
        InputError: No mapping, a joint that does not exist, a number below 0 or none.
    """
    if not isinstance(value, Mapping):
        raise InputError(
            f"{what} is {shown(value)}; expected a mapping from joints to numbers >= 0"
        )
    known = (*JOINT_GROUPS, *JOINT_NAMES, *extra)
    checked = {}
    for key, given in value.items():
        if key not in known:
            hint = did_you_mean(key, known, count=3, form=repr, otherwise=".")
            raise InputError(
                f"{what}: there is no joint {key!r}{hint} Expected one of the groups "
                f"{', '.join((*JOINT_GROUPS, *extra))}, or a name of halfphysics.JOINT_NAMES"
            )
        checked[key] = number(given, f"{what}[{key!r}]", least=0.0, unit=unit)
    return JointValues(checked)


def stiffness_array(value: Any, what: str) -> Array:
    """Stiffness of every joint (55,) of a number, a mapping or an array (55,); 0 at the root.

    Raises:
        InputError: Anything else, or a number below 0 or not finite.
    """
    if isinstance(value, Mapping):
        out = joint_values(value, what).resolve(1.0)
    elif _constant(value):
        out = np.full(N_JOINTS, number(value, what, least=0.0))
    else:
        out = stiffness_rows(value, what, (N_JOINTS,))
    out[0] = 0.0
    return out


def stiffness_rows(value: Any, what: str, shape: tuple[int, ...], expected: str = "") -> Array:
    """`value` as an array of that shape, of numbers >= 0; `expected` is for messages."""
    expected = expected or str(shape)
    try:
        out = np.array(array_of(value), dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: found {shown(value)}, expected numbers {expected}") from None
    if out.shape != shape:
        raise InputError(f"{what}: found shape {out.shape}, expected {expected}")
    if not np.isfinite(out).all() or (out < 0.0).any():
        worst = np.argwhere(~(np.isfinite(out) & (out >= 0.0)))[0]
        at = ", ".join(map(str, worst))
        raise InputError(
            f"{what}: found {out[tuple(worst)]} at [{at}]; expected finite numbers >= 0"
        )
    return out


def stiffness_over_time(value: Any, frames: int, people: int) -> Array | None:
    """The argument `stiffness` of `simulate` as stiffness (T, people, 55), 0 at the roots.

    One value for all people, or a list or tuple of one for each: a number, numbers by joint group
    or joint (1 for joints that are not named), or over time an array (T,) or (T, 55).

    Raises:
        InputError: Another shape or number of arrays, a joint that does not exist, or numbers
            below 0 or not finite.
    """
    if value is None:
        return None
    each = [value] * people
    if isinstance(value, list | tuple) and len(value) == people:
        # Of one person, nested lists may also be one row of 55 a frame.
        rows = people == 1 and frames == 1 and _dimensions(value[0]) == 1
        each = each if rows else list(value)
    out = np.empty((frames, people, N_JOINTS))
    for person, its in enumerate(each):
        what = "stiffness" if people == 1 else f"stiffness of person {person}"
        if _constant(its):
            out[:, person] = stiffness_array(its, what)
            continue
        wide = _dimensions(its) == 2
        shape = (frames, N_JOINTS) if wide else (frames,)
        checked = stiffness_rows(its, what, shape, f"({frames},) or ({frames}, {N_JOINTS})")
        out[:, person] = checked if wide else checked[:, None]
    out[:, :, 0] = 0.0
    return out


def stiffness_of_motions(usual: Array, motions: Sequence[Motion]) -> Array | None:
    """Stiffness (T, people, 55) of motions that scale the usual one (55,); None: none does."""
    if all(motion.stiffness_scale is None for motion in motions):
        return None
    scales = [1.0 if (its := m.stiffness_scale) is None else its for m in motions]
    rows = [np.broadcast_to(usual * scale, (len(motions[0]), N_JOINTS)) for scale in scales]
    return np.stack(rows, axis=1)


def _constant(value: Any) -> bool:
    """Whether a stiffness is constant over time."""
    return isinstance(value, Mapping) or (
        not isinstance(value, list | tuple) and _dimensions(value) == 0
    )


def _dimensions(value: Any) -> int:
    """Dimensions of an array or of lists; -1: neither."""
    try:
        return as_array(value).ndim
    except (TypeError, ValueError):
        return -1
