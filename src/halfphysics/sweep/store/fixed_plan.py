"""The plan of a sweep's folder: fixed at the first start, like its inputs and its program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from halfphysics.errors import FileError, InputError
from halfphysics.sweep.plan.layout import PLAN
from halfphysics.sweep.plan.plan import Plan


def check_plan(folder: Path, plan: Plan) -> Plan | None:
    """The plan in the folder; None if the folder has no plan.

    Raises:
        InputError: The folder has another plan.
        FileError: The plan in the folder cannot be read.
    """
    path = folder / PLAN
    if not path.exists():
        return None
    try:
        there = Plan.load(path)
    except FileError as error:
        raise FileError(
            f"{error}. Put the plan of this folder back, or give another folder (--out)"
        ) from None
    if there.identity != plan.identity:
        raise InputError(
            f"{folder}: holds another plan: {_difference(there.document(), plan.document())}. Run "
            f"that one (halfphysics sweep {path} --out {folder}), or give another folder (--out)"
        )
    return there


def _difference(there: Any, here: Any, where: str = "") -> str:
    """The first difference between two documents, as text."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in sorted({*there, *here}, key=str):
            if there.get(key) != here.get(key) and f"{where}.{key}" != "outputs.folder":
                return _difference(there.get(key), here.get(key), f"{where}.{key}".lstrip("."))
    texts = [json.dumps(value, ensure_ascii=False, default=str) for value in (there, here)]
    short = [text if len(text) <= 60 else f"{text[:57]}..." for text in texts]
    return f"{where or 'plan'} is {short[0]} there and {short[1]} now"
