"""YAML and JSON documents as trees that know where in the file each value stands.

Strict: a duplicate key, a key that is not text, and a value that is not plain data are errors.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from halfphysics.errors import FileError

_MAX_DEPTH = 20  # scene files and sweep files need five
#: Text that is read [bytes], by suffix: a moving thing of an hour at 30 fps is 15 MB of JSON. YAML
#: takes a second for each MB.
_MOST_BYTES = {".json": 2**24, "": 2**22}
#: Values that are read: each takes 300 bytes.
_MOST_VALUES = 1_500_000
#: JSON of more letters is read without the lines of its values: with them it takes as long as YAML.
_LONG = 2**18

# YAML 1.2 numbers such as 1e3, which PyYAML (YAML 1.1) would take for text.
_FLOAT = re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$")
# Whole numbers of YAML 1.1 only, such as 1_000, 1:30, 0b11 and 010, which is 8 there.
_OLD_INT = re.compile(r"[_:]|^[-+]?0[b0-9]")
# An escape of JSON; with groups: a pair of surrogates, one character, which YAML refuses.
_ESCAPE = re.compile(
    r"\\(?:u(d[89ab][0-9a-f]{2})\\u(d[c-f][0-9a-f]{2})|.)", re.IGNORECASE | re.DOTALL
)


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A value of a document: a dict or list of entries, a number, text, bool or None.

    `where` is its path in the document, such as "objects.ball.mass"; `line` counts from 1 (0: the
    document is not text).
    """

    value: Any
    where: str
    line: int
    file: Path

    def error(self, message: str) -> FileError:
        """`message`, led by file, line and path in the document."""
        place = f", {self.where}" if self.where else ""
        line = f", line {self.line}" if self.line else ""
        return FileError(f"{self.file}{line}{place}: {message}")


def read_tree(path: Path, keys: str) -> Entry:
    """The document of a .yaml, .yml or .json file; raises `FileError`.

    `keys` names, for the message of an empty file, some of those it should have.
    """
    import yaml

    try:
        _check_size(path, path.stat().st_size)
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: not a text file (UTF-8): {error}") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    _check_values(path, text)
    if path.suffix.lower() == ".json":
        document = _json(path, text)
        if len(text) > _LONG:
            return plain_tree(document, path)
        # JSON is YAML but for tabs, which JSON allows between values only, and for surrogates.
        text = _ESCAPE.sub(_joined, text.replace("\t", " "))
    loader = _loader(yaml)(text)
    try:
        root = loader.get_single_node()
        if root is None:
            raise FileError(f"{path}: the file is empty, expected a mapping with {keys}")
        return _Builder(path, loader.construct_object)(root, "", 0)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark is not None else ""
        problem = getattr(error, "problem", None) or str(error)
        raise FileError(f"{path}{line}: not valid YAML: {problem}") from None
    except RecursionError:
        raise FileError(f"{path}: nested too deeply") from None
    finally:
        loader.dispose()


def check_readable(path: Path, text: str) -> None:
    """That `read_tree` would read a text that is to be written to `path`; raises `FileError`."""
    _check_size(path, len(text.encode()))
    _check_values(path, text)


def _check_size(path: Path, size: int) -> None:
    suffix = path.suffix.lower()
    most = _MOST_BYTES.get(suffix, _MOST_BYTES[""])
    if size > most:
        faster = "" if suffix == ".json" else ", or write it as .json, which is read faster"
        raise FileError(
            f"{path}: {size / 2**20:.1f} MiB of text, expected at most {most / 2**20:.0f}. Put "
            f"meshes into files of their own{faster}"
        )


def _check_values(path: Path, text: str) -> None:
    if text.count(",") > _MOST_VALUES:
        raise FileError(
            f"{path}: more than {_MOST_VALUES} values, expected fewer. Put meshes into files of "
            "their own"
        )


def _json(path: Path, text: str) -> Any:
    """The plain data of JSON text."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs) and len(text) > _LONG:  # shorter ones: with their lines
            names = [name for name, _ in pairs]
            twice = next(name for name in names if names.count(name) > 1)
            raise FileError(f"{path}: key {twice!r} is given twice; keep one")
        return found

    try:
        return json.loads(text, object_pairs_hook=once)
    except json.JSONDecodeError as error:
        raise FileError(f"{path}, line {error.lineno}: not valid JSON: {error.msg}") from None
    except (RecursionError, MemoryError):
        raise FileError(f"{path}: nested too deeply") from None
    except ValueError as error:  # a whole number of thousands of digits
        raise FileError(f"{path}: not valid JSON: {error}") from None


def _joined(escape: re.Match[str]) -> str:
    """The character of a pair of surrogates; any other escape as it is."""
    if escape[1] is None:
        return escape[0]
    return bytes.fromhex(escape[1] + escape[2]).decode("utf-16-be")


def plain_tree(value: Any, file: Path, where: str = "", depth: int = 0) -> Entry:
    """Plain data (of a document inside another file) as a tree; it has no lines of its own."""
    if depth > _MAX_DEPTH:
        raise FileError(f"{file}, {where}: nested too deeply")
    if isinstance(value, Mapping):
        value = {
            k: plain_tree(v, file, f"{where}.{k}".lstrip("."), depth + 1) for k, v in value.items()
        }
    elif isinstance(value, list | tuple):
        value = [plain_tree(v, file, f"{where}[{i}]", depth + 1) for i, v in enumerate(value)]
    return Entry(value=value, where=where, line=0, file=file)


def yaml_text(document: Mapping[str, Any]) -> str:
    """Plain data as YAML, from which `read_tree` reads the same: text like 1e3 is in quotes."""
    import yaml

    dumper = _with_floats(yaml.SafeDumper)
    return str(
        yaml.dump(document, Dumper=dumper, sort_keys=False, default_flow_style=None, width=100)
    )


def _loader(yaml: Any) -> Any:
    return _with_floats(getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _with_floats(base: Any) -> Any:
    """A loader or dumper of PyYAML that also takes numbers such as 1e3 for numbers."""

    class Changed(base):  # type: ignore[misc]
        pass

    Changed.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+0123456789."))
    return Changed


class _Builder:
    """Entries from YAML nodes. A node that aliases name again is built once."""

    def __init__(self, file: Path, scalar: Callable[[Any], Any]) -> None:
        self.file = file
        self.scalar = scalar
        self.built: dict[int, Any] = {}

    def __call__(self, node: Any, where: str, depth: int) -> Entry:
        here = Entry(value=None, where=where, line=node.start_mark.line + 1, file=self.file)
        if depth > _MAX_DEPTH:
            raise here.error("nested too deeply")
        if id(node) not in self.built:
            self.built[id(node)] = self._value(node, here, depth)
        return Entry(value=self.built[id(node)], where=where, line=here.line, file=self.file)

    def _value(self, node: Any, here: Entry, depth: int) -> Any:
        if node.id == "sequence":
            return [
                self(child, f"{here.where}[{i}]", depth + 1) for i, child in enumerate(node.value)
            ]
        if node.id == "mapping":
            return self._mapping(node, here, depth)
        kind = node.tag.rsplit(":", 1)[-1]
        if kind not in ("str", "int", "float", "bool", "null"):
            return node.value  # dates and the like are text here
        try:
            # Numbers of YAML 1.1 only are text here, refused as numbers.
            if kind == "int" and _OLD_INT.search(node.value):
                return node.value
            if kind == "float" and re.search(r"[_:]", node.value):
                return node.value
            return self.scalar(node)
        except (ValueError, TypeError):
            return node.value

    def _mapping(self, node: Any, here: Entry, depth: int) -> dict[str, Entry]:
        result: dict[str, Entry] = {}
        for key_node, child in node.value:
            at = Entry(
                value=None, where=here.where, line=key_node.start_mark.line + 1, file=self.file
            )
            if key_node.id != "scalar" or key_node.tag != "tag:yaml.org,2002:str":
                shown = getattr(key_node, "value", "")
                raise at.error(f"found key {shown!r} that is not text; put it in quotes")
            key = key_node.value
            if key in result:
                raise at.error(
                    f"key {key!r} is given twice, first in line {result[key].line}; keep one"
                )
            entry = self(child, f"{here.where}.{key}".lstrip("."), depth + 1)
            result[key] = replace(entry, line=at.line)  # where the key is: easiest to find
        return result
