"""Names of pairs: of what friction and ignoring are said."""

from __future__ import annotations

from halfphysics.base.suggestions import did_you_mean
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES

#: Stands for every part of every person, where a pair of things is named.
PERSON = "person"


def of_person(name: str) -> bool:
    """Is it a person, or a part of one?"""
    return name == PERSON or name.startswith(f"{PERSON}/")


def wider(a: str, b: str) -> list[frozenset[str]]:
    """The pairs under which something may have been said of two, the closest first."""
    of_a, of_b = ([n, PERSON] if of_person(n) and n != PERSON else [n] for n in (a, b))
    return [frozenset((x, y)) for x in of_a for y in of_b]


def check_part(what: str, name: str) -> None:
    """Raises `InputError` where a person has no such part."""
    part = name.removeprefix(f"{PERSON}/")
    if part not in JOINT_NAMES:
        hint = did_you_mean(part, JOINT_NAMES, form=lambda name: f"'{PERSON}/{name}'")
        raise InputError(
            f"{what}: a person has no part called {part!r}{hint}. Parts are named by their joints, "
            "see halfphysics.JOINT_NAMES"
        )


def ends(pair: frozenset[str]) -> tuple[str, str]:
    """Both names of a pair, in order; twice the same of a thing with itself."""
    names = sorted(pair)
    return names[0], names[-1]
