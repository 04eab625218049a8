"""The cases of `tools/compare_results.py`: what is simulated, measured and written, by name.

A family of cases is one module here with a function ``cases()`` that yields `Case`s, and one line
in `all_cases`. Cases reach the package through its public names alone, so that they go on working
when modules move; what they need beyond that they build themselves.
"""

from __future__ import annotations

from result_cases.case import Case


def all_cases() -> dict[str, Case]:
    """Every case by name, in the order of the record; building them simulates nothing."""
    from result_cases import (
        baselines,
        clips,
        files,
        hosted,
        live,
        measured,
        meshes,
        settings,
        varied,
    )

    families = (settings, baselines, clips, meshes, live, hosted, measured, files, varied)
    out: dict[str, Case] = {}
    for family in families:
        for case in family.cases():
            if case.name in out:
                raise ValueError(f"two cases are called {case.name!r}")
            out[case.name] = case
    return out
