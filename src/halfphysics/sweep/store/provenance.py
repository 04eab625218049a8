"""What a sample says of the program that made it.

The bytes of a sample depend on the package itself (its code, native core and default body) and on
what `halfphysics.base.code_hash` lists: mujoco compiles masses and shapes, numpy, scipy and trimesh
compute, coacd cuts meshes, zlib packs. Where one differs, what is stored is another program's and
is not taken for its own. Everything else (Python, the operating system, h5py) cannot change a
number, and is in no file.
"""

from __future__ import annotations

from functools import cache

from halfphysics.base.code_hash import engines, program


@cache
def _versions() -> tuple[tuple[str, str | None], ...]:
    from halfphysics import __version__

    own = {"halfphysics": __version__, "program": program()}
    return tuple((own | dict(engines())).items())


def versions() -> dict[str, str | None]:
    """Names and versions that decide a sample's bytes, for its card.

    "program" is a SHA-256 over all of them and over the package's files; None stands for an
    optional package that is not installed.
    """
    return dict(_versions())


def changed(stored: dict[str, str | None], program: str | None = None) -> list[str]:
    """In words, what of the versions in a card is not this program's (or that of `program`)."""
    here = versions() if program is None else {**versions(), "program": program}
    words = []
    for name in sorted({*stored, *here} - {"program"}):
        if stored.get(name) != here.get(name):
            words.append(f"{name} {stored.get(name)} there, {here.get(name)} here")
    if stored.get("program") != here["program"]:
        one, other = (str(which)[:12] for which in (stored.get("program"), here["program"]))
        words.append(f"the program ({one}... there, {other}... here)")
    return words
