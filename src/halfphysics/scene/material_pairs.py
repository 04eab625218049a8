"""Friction and exclusions between pairs of scene items, and the names of such pairs."""

from __future__ import annotations

from collections.abc import Callable, Collection

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES

#: In a pair: every part of every person.
PERSON = "person"


def of_person(name: str) -> bool:
    """Whether the name means the people or one part of them."""
    return name == PERSON or name.startswith(f"{PERSON}/")


def wider(a: str, b: str) -> list[frozenset[str]]:
    """The pairs that may define a property of `a` with `b`, the most specific first."""
    of_a, of_b = ([n, PERSON] if of_person(n) and n != PERSON else [n] for n in (a, b))
    return [frozenset((x, y)) for x in of_a for y in of_b]


def check_part(what: str, name: str) -> None:
    """Raises `InputError` where a person has no such part."""
    part = name.removeprefix(f"{PERSON}/")
    if part not in JOINT_NAMES:
        hint = did_you_mean(
            part, JOINT_NAMES, form=lambda name: f"'{PERSON}/{name}'", otherwise="."
        )
        raise InputError(
            f"{what}: a person has no part called {part!r}{hint} Parts are named by their joints, "
            "see halfphysics.JOINT_NAMES"
        )


def ends(pair: frozenset[str]) -> tuple[str, str]:
    """Both names of a pair, sorted; the same name twice for a pair of equal names."""
    names = sorted(pair)
    return names[0], names[-1]


def checked_pair(what: str, a: str, b: str, items: Collection[str]) -> frozenset[str]:
    """The pair of two names, each of an item, "person" or "person/PART".

    Raises:
        InputError: An unknown name, or the same item twice.
    """
    known = [*items, PERSON]
    for name in (a, b):
        if isinstance(name, str) and name.startswith(f"{PERSON}/"):
            check_part(what, name)
        elif not isinstance(name, str) or name not in known:
            hint = did_you_mean(name, known, form=repr, otherwise=".")
            raise InputError(
                f"{what}: the scene has nothing called {shown(name)}{hint} "
                f"It has: {', '.join(known)}. Add it first."
            )
    if a == b and not of_person(a):
        raise InputError(f"{what}: found {a!r} twice, expected two different things")
    return frozenset((a, b))


class MaterialPairs:
    """Friction coefficients of pairs, and pairs that pass through each other.

    A property of a pair with "person/PART" has precedence over that of the pair with "person".
    """

    def __init__(self) -> None:
        self._friction: dict[frozenset[str], float] = {}
        self._ignored: dict[frozenset[str], None] = {}

    def set_friction(self, pair: frozenset[str], mu: float) -> None:
        """Coulomb friction `mu` of a pair."""
        self._friction[pair] = mu

    def ignore(self, pair: frozenset[str]) -> None:
        """Let a pair pass through each other."""
        self._ignored[pair] = None

    def friction(self, a: str, b: str, own: Callable[[str], float]) -> float:
        """Coulomb friction of `a` with `b`; without one of the pair, the smaller `own` friction."""
        defined = [self._friction[p] for p in wider(a, b) if p in self._friction]
        return defined[0] if defined else min(own(a), own(b))

    def ignores(self, a: str, b: str) -> bool:
        """Whether `a` and `b` pass through each other."""
        return any(pair in self._ignored for pair in wider(a, b))

    @property
    def friction_pairs(self) -> tuple[tuple[str, str, float], ...]:
        """(a, b, mu), names of a pair sorted, in the order of definition."""
        return tuple((*ends(pair), mu) for pair, mu in self._friction.items())

    @property
    def ignored_pairs(self) -> tuple[tuple[str, str], ...]:
        """(a, b), names of a pair sorted, in the order of definition."""
        return tuple(ends(pair) for pair in self._ignored)

    def copied(self, without: str | None = None) -> MaterialPairs:
        """A copy without the pairs of the item `without`."""
        copy = MaterialPairs()
        copy._friction = {p: mu for p, mu in self._friction.items() if without not in p}
        copy._ignored = {p: None for p in self._ignored if without not in p}
        return copy
