"""Values of options from text: what is expected is named in plain words, and in help in capitals.

The reader of arguments (tyro) would speak of ``{None}|FLOAT`` and of ``<class 'int'>``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

import tyro

from halfphysics.cli.joint_options import joint_spec

#: Type -> its word in help, and in messages.
_WORDS: Mapping[Any, tuple[str, str]] = {
    float: ("NUMBER", "a number"),
    int: ("N", "a whole number"),
    str: ("TEXT", "text"),
    Path: ("PATH", "a path"),
}
#: Words for "not given", where an option has a value by default.
_NOTHING = ("none", "None")


def value_types() -> Any:
    """A context in which tyro reads values by the rules of this file."""
    registry = tyro.constructors.ConstructorRegistry()

    @registry.primitive_rule
    def rule(info: tyro.constructors.PrimitiveTypeInfo) -> Any:
        return joint_spec(info.type) or plain_spec(info.type)

    return registry


def plain_spec(kind: Any) -> Any:
    """How tyro reads a number, text, path or word; None: another type."""
    kinds = _members(kind)
    optional = NoneType in kinds
    kinds = [one for one in kinds if one is not NoneType]
    if str in kinds:
        kinds = [str]  # text that is read later
    words = [word for one in kinds if get_origin(one) is Literal for word in get_args(one)]
    types = [one for one in kinds if one in _WORDS]
    if not kinds or len(types) + sum(get_origin(one) is Literal for one in kinds) < len(kinds):
        return None
    if not all(isinstance(word, str) for word in words):
        return None

    def read(arguments: list[str]) -> Any:
        (text,) = arguments
        if text in words:
            return text
        if optional and text in _NOTHING and not {str, Path} & set(types):
            return None
        for one in types:
            try:
                return one(text)
            except ValueError:
                continue
        choices: list[str] = [*(_WORDS[one][1] for one in types), *words]
        expected = " or ".join(filter(None, (", ".join(choices[:-1]), choices[-1])))
        raise ValueError(f"found {text!r}, expected {expected}")

    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar="|".join([*(_WORDS[one][0] for one in types), *words]),
        instance_from_str=read,
        is_instance=lambda value: True,
        str_from_instance=lambda value: ["none" if value is None else str(value)],
    )


def _members(kind: Any) -> list[Any]:
    """The types of a union, or the type itself."""
    if get_origin(kind) in (Union, UnionType):
        return [member for one in get_args(kind) for member in _members(one)]
    return [kind]
