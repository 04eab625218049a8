"""Finds what only Python calls so in a text for users of the command line."""

from __future__ import annotations

import inspect
import re
from functools import cache

import halfphysics as hp
from halfphysics import errors

#: Arguments of Python functions that are options of commands.
_ARGUMENTS = "fps|up|floor|hands|model|gender|frames|clip|assets|objects|body|format|mode|scene"
_QUOTED = re.compile(r"(?<![\w=])'[^']*'(?!\w)|\S*[/\\]\S*")


@cache
def _pattern() -> re.Pattern[str]:
    public = [name for name in hp.__all__ if name[0].isupper() or "_" in name.strip("_")]
    raised = [name for name, _ in inspect.getmembers(errors, inspect.isclass)]
    names = "|".join(sorted({*public, *raised}, key=len, reverse=True))
    classes = "|".join(name for name in public if name[0].isupper() and "_" not in name)
    return re.compile(
        # classes and functions of the package; a capital at the beginning of a sentence is none
        rf"\b(?!(?:{classes})\b)(?:{names})\b|(?<!\A)(?<!\. )(?<!3D )(?<![-\w])(?:{classes})\b(?!-)"
        rf"|\b(?:{classes})\.\w"
        r"|\b(?:None|True|False)\b|\b\w*Path\(|<class |\barray\(|\bdtype\("
        r"|\bhp\.\w|\bhalfphysics\.[A-Za-z]\w|\b[A-Z]{2,}_[A-Z]{3,}\w*S\b"
        r"|\b(?:motion|body|scene|result|self)\.\w+\(|\badd_(?:static|object|moving)\b"
        rf"|(?<![\w-])(?:{_ARGUMENTS})=(?!=)"
        r"|\b(?:Type|Key|Value|Attribute|Index|OS)Error\b|Traceback"
    )


def python_names(text: str) -> list[str]:
    """The names in a text; what stands in quotes, and paths, is the user's."""
    return [found[0] for found in _pattern().finditer(_QUOTED.sub(" ", text))]
