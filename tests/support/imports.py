"""Imports of the package's modules, and includes of the native core's files."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from support.paths import ROOT

PACKAGE = ROOT / "src" / "halfphysics"
NATIVE = ROOT / "src" / "native"


@dataclass(frozen=True, order=True)
class Import:
    """One import inside the package.

    Attributes:
        source: Importing module, without "halfphysics."; "" is the package itself.
        target: Imported module, likewise; of the package itself also "_native", "_render" and
            "__version__".
        kind: "top" runs with the module, "late" when a function is called, "type" never.
    """

    source: str
    target: str
    kind: str


def modules() -> dict[str, Path]:
    """Every module of the package with its file."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imports() -> frozenset[Import]:
    """Every import from one module of the package to another; read once."""
    known = modules()
    return frozenset(
        Import(source, target, kind)
        for source, path in known.items()
        for target, kind in _of(source, path, known)
        if target != source
    )


def _of(source: str, path: Path, known: dict[str, Path]) -> Iterator[tuple[str, str]]:
    """Imports of one file, and when they run."""
    package = source if path.name == "__init__.py" else source.rpartition(".")[0]
    for node, kind in _statements(ast.parse(path.read_text(encoding="utf-8")), "top"):
        if isinstance(node, ast.Import):
            names = [name.name for name in node.names]
            yield from ((_inside(name), kind) for name in names if _is_ours(name))
            continue
        module = node.module or ""
        if node.level:
            above = ["halfphysics", *filter(None, package.split("."))]
            module = ".".join([*above[: len(above) - node.level + 1], *filter(None, [module])])
        if not _is_ours(module):
            continue
        for name in node.names:
            full = _inside(f"{module}.{name.name}")
            yield (full if full in known or not _inside(module) else _inside(module)), kind


def _statements(node: ast.AST, kind: str) -> Iterator[tuple[ast.Import | ast.ImportFrom, str]]:
    """Import statements below a node, and when they run."""
    for child in ast.iter_child_nodes(node):
        inner = kind
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            inner = "late"
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            inner = "type"
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, inner
        yield from _statements(child, inner)


def _is_ours(module: str) -> bool:
    return module.split(".")[0] == "halfphysics"


def _inside(module: str) -> str:
    """The name without "halfphysics."."""
    return module.partition(".")[2]


def cycles(arrows: dict[str, set[str]]) -> list[list[str]]:
    """Groups of nodes that reach each other (Tarjan's strongly connected components)."""
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in sorted(arrows.get(node, ())):
            if other not in order:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], order[other])
        if low[node] == order[node]:
            group = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(arrows):
        if node not in order:
            visit(node)
    return found


@cache
def includes() -> frozenset[tuple[str, str]]:
    """Every include from one file of the native core to another, below src/native; read once."""
    found = set()
    for path in sorted(NATIVE.rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        for name in re.findall(r'^#include "([^"]+)"', path.read_text(encoding="utf-8"), re.M):
            beside, below = path.parent / name, NATIVE / name
            target = beside if beside.exists() else below
            assert target.exists(), f"{path}: #include of {name}, which is not there"
            found.add((path.relative_to(NATIVE).as_posix(), target.relative_to(NATIVE).as_posix()))
    return frozenset(found)
