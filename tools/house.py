"""How large the pieces of the code are: what a reader would have to hold in mind at once.

    python tools/house.py            lists, and exit code 1 if a piece is over its bound without a reason
    python tools/house.py --all      with the pieces whose reason is known

Bounds: 60 lines of a C++ function, 50 of a Python one (docstring not counted), 25 methods and 25
data members of a class, 400 lines of a file, and no tuning constant of the core outside
`src/native/tuning.h`. `REASONS` names each piece that is over a bound, and why. Needs the `dev`
extra (tree-sitter reads the C++).
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHON_LINES, CPP_LINES, FILE_LINES, METHODS, MEMBERS = 50, 60, 400, 25, 25
#: Where the constants of the core stand.
TUNING = "src/native/tuning.h"

#: (file, name) of a piece that is over a bound -> why it stays.
REASONS: dict[tuple[str, str], str] = {
    ("src/native/dynamics/kinematic_tree.h", "Model"): "the arrays of a model, as MuJoCo has them",
    ("src/native/tuning.h", ""): "one file for all constants, each with its reason",
    ("src/native/collision/clearance_query.cpp", "kFar"): "infinity, not a choice",
    ("src/native/collision/collision_shape.cpp", "kBlock"): "the width of a vector loop",
    ("src/native/geometry/triangle_cluster.h", "kFourPi"): "mathematics",
    ("src/native/geometry/triangle_tree.h", "kUnknown"): "a mark, not a choice",
    ("src/native/geometry/triangle_tree.h", "kStack"): "the size of a buffer, from the depth bound",
    ("tests/evidence/test_evidence.py", ""): "one file of tests for one file of code",
    ("tools/bake_body.py", "bake"): "run by hand, in an environment of its own, once per body",
    ("tools/joint_regressor.py", "fit"): "run by hand, in an environment of its own, once per body",
}


@dataclass(frozen=True)
class Piece:
    """A piece of code over a bound: which bound, where, and by how much."""

    bound: str
    file: str
    name: str
    size: int

    @property
    def reason(self) -> str | None:
        return REASONS.get((self.file, self.name))


def tracked(*patterns: str) -> list[Path]:
    """The files of the repository that git knows or would add."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return [ROOT / line for line in listed.stdout.split() if (ROOT / line).is_file()]


def file_sizes(path: Path, where: str) -> Iterator[Piece]:
    lines = path.read_text(encoding="utf-8").count("\n")
    if lines > FILE_LINES:
        yield Piece("file", where, "", lines)


# ---------------------------------------------------------------- Python
def python_pieces(path: Path, where: str) -> Iterator[Piece]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            size = (node.end_lineno or node.lineno) - node.lineno + 1 - docstring_lines(node)
            if size > PYTHON_LINES:
                yield Piece("function", where, node.name, size)
        elif isinstance(node, ast.ClassDef):
            methods = sum(isinstance(item, ast.FunctionDef) for item in node.body)
            if methods > METHODS:
                yield Piece("methods", where, node.name, methods)
            members = len(python_members(node))
            if members > MEMBERS:
                yield Piece("members", where, node.name, members)


def docstring_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    first = node.body[0]
    if ast.get_docstring(node) is None:
        return 0
    return (first.end_lineno or first.lineno) - first.lineno + 1


def python_members(node: ast.ClassDef) -> set[str]:
    """Fields of the class body, and attributes that its methods set on `self`."""
    names = {
        item.target.id
        for item in node.body
        if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
    }
    for item in ast.walk(node):
        if (
            isinstance(item, ast.Attribute)
            and isinstance(item.ctx, ast.Store)
            and isinstance(item.value, ast.Name)
            and item.value.id == "self"
        ):
            names.add(item.attr)
    return names


# ---------------------------------------------------------------- C++
class Cpp:
    """Reads C++ with tree-sitter."""

    def __init__(self) -> None:
        import tree_sitter_cpp
        from tree_sitter import Language, Parser

        self.parser = Parser(Language(tree_sitter_cpp.language()))

    def pieces(self, path: Path, where: str) -> Iterator[Piece]:
        pending = [self.parser.parse(path.read_bytes()).root_node]
        while pending:
            node = pending.pop()
            pending += node.children
            if node.type == "function_definition":
                size = node.end_point[0] - node.start_point[0] + 1
                if size > CPP_LINES:
                    yield Piece("function", where, declared(node), size)
            elif node.type in ("class_specifier", "struct_specifier"):
                yield from self._class(node, where)
            elif node.type == "declaration" and where != TUNING:
                name = constant(node)
                if name is not None:
                    yield Piece("constant", where, name, 1)

    def _class(self, node, where: str) -> Iterator[Piece]:
        body = node.child_by_field_name("body")
        if body is None:
            return
        name = text(node.child_by_field_name("name"))
        methods = members = 0
        for item in body.children:
            inner = item.children[-1] if item.type == "template_declaration" else item
            if inner.type == "function_definition" or (
                inner.type in ("field_declaration", "declaration") and is_function(inner)
            ):
                methods += 1
            elif inner.type == "field_declaration" and not is_static(inner):
                members += len(inner.children_by_field_name("declarator"))
        if methods > METHODS:
            yield Piece("methods", where, name, methods)
        if members > MEMBERS:
            yield Piece("members", where, name, members)


def is_function(node) -> bool:
    pending = list(node.children_by_field_name("declarator"))
    while pending:
        inner = pending.pop()
        if inner.type == "function_declarator":
            return True
        pending += inner.children_by_field_name("declarator")
    return False


def is_static(node) -> bool:
    return any(c.type == "storage_class_specifier" for c in node.children)


def constant(node) -> str | None:
    """The name of a `constexpr` number at namespace scope, such as a `kMostSomething`."""
    if not any(text(c) == "constexpr" for c in node.children):
        return None
    scope = node.parent
    while scope is not None and scope.type in ("declaration_list", "namespace_definition"):
        scope = scope.parent
    if scope is None or scope.type != "translation_unit" or is_function(node):
        return None
    return declared(node)


def declared(node) -> str:
    inner = node.child_by_field_name("declarator")
    while inner is not None and inner.child_by_field_name("declarator") is not None:
        inner = inner.child_by_field_name("declarator")
    return text(inner)


def text(node) -> str:
    return "" if node is None else node.text.decode()


# ---------------------------------------------------------------- all
def pieces() -> list[Piece]:
    """Everything over its bound."""
    found: list[Piece] = []
    for path in tracked("src/*.py", "evidence/*.py", "tools/*.py", "tests/*.py"):
        where = path.relative_to(ROOT).as_posix()
        found += [*file_sizes(path, where)]
        if not where.startswith("tests/"):
            found += python_pieces(path, where)
    cpp = Cpp()
    for path in tracked("src/native/*.h", "src/native/*.cpp"):
        where = path.relative_to(ROOT).as_posix()
        found += [*file_sizes(path, where), *cpp.pieces(path, where)]
    return found


def main() -> int:
    found = pieces()
    open_ones = [piece for piece in found if piece.reason is None]
    for piece in found if "--all" in sys.argv else open_ones:
        reason = f"   ({piece.reason})" if piece.reason else ""
        print(f"{piece.bound:10}{piece.size:5}  {piece.file} {piece.name}{reason}")
    known = {(piece.file, piece.name) for piece in found}
    stale = [key for key in REASONS if key not in known]
    for file, name in stale:
        print(f"no longer over a bound, take it out of REASONS: {file} {name}")
    print(f"{len(open_ones)} over a bound without a reason, {len(found) - len(open_ones)} with one")
    return 1 if open_ones or stale else 0


if __name__ == "__main__":
    sys.exit(main())
