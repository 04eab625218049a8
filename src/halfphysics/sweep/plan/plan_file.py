"""Sweep files, YAML or JSON: read strictly, written back. The format: docs/sweeps.md."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from halfphysics.base.atomic import atomic_write
from halfphysics.base.document_entries import (
    describe,
    guarded,
    mapping,
    named_entries,
    number,
    text,
)
from halfphysics.base.document_tree import Entry, plain_tree, read_tree, yaml_text
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.motion.motion import MODELS
from halfphysics.sweep.plan.choices import OWN, BodyChoice, SceneChoice
from halfphysics.sweep.plan.inputs import Inputs, file_options, scenario_options
from halfphysics.sweep.plan.plan import VERSION, Labels, Outputs, Plan
from halfphysics.sweep.plan.values import Spec, spec

T = TypeVar("T")
_SUFFIXES = (".yaml", ".yml", ".json")
_KEYS = (
    "version",
    "base",
    "inputs",
    "bodies",
    "scenes",
    "grounded",
    "factors",
    "samples",
    "seed",
    "keep",
    "keep_after",
    "settings",
    "labels",
    "outputs",
)
_BODY_KEYS = ("stature", "model", "allow_mismatch")
_LABEL_KEYS = ("threshold", "also")
_OUTPUT_KEYS = ("folder", "formats", "variants_per_shard", "batch", "results", "support")


def load_plan(path: str | os.PathLike[str]) -> Plan:
    """Implementation of `Plan.load`; see there."""
    path = file_path(path)
    if path.suffix.lower() not in _SUFFIXES:
        raise FileError(
            f"{path}: found suffix {path.suffix!r}, expected a sweep file {', '.join(_SUFFIXES)}"
        )
    if not path.is_file():
        raise FileError(f"{path}: there is no such file, expected a sweep ({', '.join(_SUFFIXES)})")
    return _plan(read_tree(path, "inputs, factors"), path.parent)


def plan_of(document: Mapping[str, Any], base: Path) -> Plan:
    """Implementation of `Plan.from_document`; see there."""
    return _plan(plain_tree(document, Path("plan")), Path(base))


def save_plan(plan: Plan, path: str | os.PathLike[str]) -> None:
    """Implementation of `Plan.save`; see there."""
    path = file_path(path)
    base: str | Path = plan.base.resolve()
    with contextlib.suppress(ValueError):  # another drive: no relative path leads there
        base = os.path.relpath(base, path.resolve().parent)
    document = plan.document()
    ordered = {"version": document.pop("version"), "base": Path(base).as_posix(), **document}
    with atomic_write(path) as handle:
        handle.write(yaml_text(ordered).encode())


def _plan(tree: Entry, folder: Path) -> Plan:
    root = mapping(tree, _KEYS)
    if "version" in root and number(root["version"]) != VERSION:
        raise root["version"].error(
            f"found version {describe(root['version'])}, expected {VERSION}; a newer halfphysics "
            "may read it"
        )
    if "inputs" not in root:
        raise tree.error(
            "found no inputs, expected a list of entries with files: (patterns) or scenarios: "
            "(names)"
        )
    base = folder / text(root["base"]) if "base" in root else folder
    given: dict[str, Any] = {
        key: _plain(root[key])
        for key in ("grounded", "samples", "seed", "keep", "keep_after", "settings")
        if key in root
    }
    given["inputs"] = _each(root["inputs"], lambda entry: _inputs(entry, base))
    if "bodies" in root:
        given["bodies"] = _each(root["bodies"], lambda entry: _body(entry, base))
    if "scenes" in root:
        given["scenes"] = _each(root["scenes"], lambda entry: _scene(entry, base))
    if "factors" in root:
        named = named_entries(root["factors"], "from names of factors to values")
        given["factors"] = {name: _spec(entry) for name, entry in named.items()}
    if "settings" in root:
        named_entries(root["settings"], "from fields of halfphysics.Settings to values")
    if "labels" in root:
        given["labels"] = _made(root["labels"], Labels, mapping(root["labels"], _LABEL_KEYS))
    if "outputs" in root:
        given["outputs"] = _made(root["outputs"], Outputs, mapping(root["outputs"], _OUTPUT_KEYS))
    return _placed(tree, lambda: Plan(**given, base=base))


def _inputs(entry: Entry, base: Path) -> Inputs:
    given = named_entries(entry, "files or scenarios, and their options")
    what = {key: _plain(given[key]) for key in ("files", "scenarios") if key in given}
    names = what.get("scenarios", ())
    if len(what) != 1:
        mapping(entry, ("files", "scenarios", *file_options(), "ground"))
        known: tuple[str, ...] = ()
    elif "files" in what:
        known = file_options()
    else:
        texts = [names] if isinstance(names, str) else names
        if not isinstance(texts, list) or not texts or not all(isinstance(n, str) for n in texts):
            raise given["scenarios"].error(
                f"expected the name of a scenario or a list of them, found "
                f"{describe(given['scenarios'])}"
            )
        known = guarded(given["scenarios"], scenario_options, texts)
    of = " for scenarios" if "scenarios" in what else " for files"
    mapping(entry, (*what, *known, "ground"), of)
    options = {key: _plain(given[key]) for key in known if key in given}
    ground = {"ground": _plain(given["ground"])} if "ground" in given else {}
    made = _placed(entry, lambda: Inputs(**what, options=options, **ground))
    for folder in made.options.get("assets", ()) if made.files else ():
        if not _at(given["assets"], base / folder).is_dir():
            raise given["assets"].error(f"there is no folder {folder!r} in {base.absolute()}")
    model = made.options.get("model") if made.files else None
    if model is not None and model not in MODELS and not _at(given["model"], base / model).exists():
        raise given["model"].error(
            f"found {model!r}, expected one of {', '.join(MODELS)} or the path of a body model in "
            f"{base.absolute()}"
        )
    return made


def _body(entry: Entry, base: Path) -> BodyChoice:
    if entry.value == OWN:
        return BodyChoice()
    if not isinstance(entry.value, dict) or not entry.value:
        raise entry.error(
            f"expected {OWN} (what the input brings), {{stature: metres}} or {{model: file or "
            f"folder}}, found {describe(entry)}"
        )
    given = mapping(entry, _BODY_KEYS)
    made = _made(entry, BodyChoice, given)
    if made.model is not None and not _at(given["model"], base / made.model).exists():
        raise given["model"].error(f"there is no {made.model!r} in {base.absolute()}")
    return made


def _scene(entry: Entry, base: Path) -> SceneChoice:
    if entry.value == OWN:
        return SceneChoice()
    name = text(entry)
    if not _at(entry, base / name).is_file():
        raise entry.error(
            f"expected {OWN} (what the input brings) or a scene file; there is no {name!r} in "
            f"{base.absolute()}"
        )
    return SceneChoice(file=name)


def _spec(entry: Entry) -> Spec:
    return _placed(entry, lambda: spec(_plain(entry)))


def _at(entry: Entry, path: Path) -> Path:
    """A path that the system can look up; it need not exist."""
    return guarded(entry, file_path, path)


def _made(entry: Entry, kind: Callable[..., T], given: Mapping[str, Entry]) -> T:
    values = {key: _plain(child) for key, child in given.items()}
    return _placed(entry, lambda: kind(**values))


def _each(entry: Entry, read: Callable[[Entry], Any]) -> tuple[Any, ...]:
    """Read one entry or each entry of a list."""
    if isinstance(entry.value, list):
        if not entry.value:
            raise entry.error("found an empty list, expected one entry or more")
        return tuple(read(child) for child in entry.value)
    return (read(entry),)


def _placed(entry: Entry, make: Callable[[], T]) -> T:
    """make(); an error message is prefixed with the place in the file.

    A message begins with its key and a colon: the place is that of the key.
    """
    try:
        return make()
    except FileError:
        raise
    except HalfPhysicsError as error:
        place, said = _innermost(entry, str(error))
        raise place.error(said) from error


def _innermost(entry: Entry, said: str) -> tuple[Entry, str]:
    """The entry named by a message, and the message without the entry's path."""
    children: dict[str, Entry] = {}
    if isinstance(entry.value, dict):
        children = {
            form: child
            for key, child in entry.value.items()
            # settings say their fields as the dataclass does
            for form in (f"{key}: ", f"Settings.{key} ", f"Settings.{key}[", f"Settings.{key}:")
        }
        for key in ("factors", "settings", "keep", "keep_after"):
            if key in entry.value and not entry.where:
                deeper, rest = _innermost(entry.value[key], said)
                if deeper is not entry.value[key]:
                    return deeper, rest
    if isinstance(entry.value, list):
        children = {f"{child.where}: ": child for child in entry.value}
    for form, child in children.items():
        if said.startswith(form):
            return child, said.removeprefix(form) if form.endswith(": ") else said
    return entry, said


def _plain(entry: Entry) -> Any:
    """An entry as plain data."""
    value = entry.value
    if isinstance(value, dict):
        return {key: _plain(child) for key, child in value.items()}
    return [_plain(child) for child in value] if isinstance(value, list) else value
