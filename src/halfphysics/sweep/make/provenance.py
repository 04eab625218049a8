"""Versions of the program that made a sample.

The bytes of a sample depend on the package itself (its code, native core and default body) and on
the packages listed by `halfphysics.base.code_hash`: mujoco compiles masses and shapes, numpy, scipy
and trimesh compute, coacd cuts meshes, zlib compresses. If one differs, a stored sample is not
reused. Everything else (Python, the operating system, h5py) changes no number and is not recorded.
"""

from __future__ import annotations

from functools import cache

from halfphysics.base.code_hash import code_hash, engines


@cache
def _versions() -> tuple[tuple[str, str | None], ...]:
    from halfphysics import __version__

    own = {"halfphysics": __version__, "program": code_hash()}
    return tuple((own | dict(engines())).items())


def versions() -> dict[str, str | None]:
    """Names and versions that decide a sample's bytes, for its card.

    "program" is a SHA-256 over all of them and over the package's files; None stands for an
    optional package that is not installed.
    """
    return dict(_versions())


def changed(stored: dict[str, str | None], code: str | None = None) -> list[str]:
    """The versions in a card that differ from those of this code (or of hash `code`), in words."""
    here = versions() if code is None else {**versions(), "program": code}
    words = []
    for name in sorted({*stored, *here} - {"program"}):
        if stored.get(name) != here.get(name):
            words.append(f"{name} {stored.get(name)} there, {here.get(name)} here")
    if stored.get("program") != here["program"]:
        one, other = (str(which)[:12] for which in (stored.get("program"), here["program"]))
        words.append(f"the program ({one}... there, {other}... here)")
    return words
