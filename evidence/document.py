"""The content of paper.json and paper-speed.json: the report as plain values."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence
from typing import Any

from evidence.model import Options, Section, to_dict
from evidence.verdicts import tally

TITLE = "Half-Physics: the paper's evidence, reproduced and extended"


def entry(
    section: Section, options: Options, values: Mapping[str, Any], failed: Mapping[str, str]
) -> dict[str, Any]:
    """A section's entry; `values` and `failed` by task key."""
    return {
        "key": section.key,
        "title": section.title,
        "about": section.about,
        "command": command(options, section.key),
        **to_dict(section.content(options, values)),
        "failed": [{"task": key, "cause": cause} for key, cause in sorted(failed.items())],
    }


def command(options: Options, key: str) -> str:
    """The command that makes a section."""
    words = ["./run evidence --only", key]
    words += ["--quick"] if options.quick else []
    words += [f"--seed {options.seed}"] if options.seed else []
    words += [f"--data {name}={_quoted(str(path))}" for name, path in sorted(options.data.items())]
    return " ".join(words)


def _quoted(text: str) -> str:
    import shlex

    return shlex.quote(text)


def document(options: Options, sections: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The whole report: the same program makes the same bytes from the same data."""
    import mujoco

    import halfphysics

    return {
        "title": TITLE,
        "halfphysics": halfphysics.__version__,
        "mujoco": mujoco.__version__,
        "quick": options.quick,
        "seed": options.seed,
        "data": {name: str(path) for name, path in sorted(options.data.items())},
        "verdict": verdict(sections),
        "sections": list(sections),
    }


def verdict(sections: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Numbers of figures of each verdict but those of quoted rows."""
    return {kind: n for kind, n in tally(sections).items() if kind != "quoted"}


def machine() -> dict[str, Any]:
    """The machine, which the speed depends on."""
    return {
        "platform": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "cores": os.cpu_count(),
    }
