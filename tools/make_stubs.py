"""Type stubs of the extensions: writes src/halfphysics/_native.pyi and _render.pyi.

    tools/build_inplace.sh && PYTHONPATH=src python tools/make_stubs.py
    PYTHONPATH=src python tools/make_stubs.py --check     # exit code 1 if they are not current

They are committed, so that a checkout that is not built is checked by mypy all the same; the tests
hold them current. Needs nanobind, whose stubgen reads the signatures of the compiled modules.
"""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "halfphysics"
MODULES = ("_native", "_render")
LINE = 100
#: How nanobind writes arrays that come from Python and are only read, or written into.
ARRAY = re.compile(
    r"Annotated\[(NDArray\[[\w.]+\]), dict\("
    r"(?:shape=\(([^)]*)\), )?order='C', device='cpu'(?:, writable=False)?\)\]"
)
HEADER = """\
# Written by tools/make_stubs.py. Arrays are C-contiguous; their shapes are
# noted where they are fixed: `*` is any length.
"""


def main() -> int:
    """Write the stubs, or with --check say whether they are current."""
    outdated = []
    for name in MODULES:
        text, path = stub(name), path_of(name)
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        outdated.append(path.name)
        if "--check" not in sys.argv[1:]:
            path.write_text(text, encoding="utf-8")
            print(f"wrote {path}")
    if outdated and "--check" in sys.argv[1:]:
        print(f"not current: {', '.join(outdated)}; run tools/make_stubs.py", file=sys.stderr)
        return 1
    return 0


def path_of(module: str) -> Path:
    """Where the stub of an extension lies."""
    return PACKAGE / f"{module}.pyi"


def stub(module: str) -> str:
    """The stub of an extension, as it is compiled."""
    from nanobind.stubgen import StubGen

    generator = StubGen(importlib.import_module(f"halfphysics.{module}"), quiet=True)
    generator.put(generator.module)
    text = ARRAY.sub(_array, generator.get())
    # Bare containers are errors under mypy's strict rules.
    text = re.sub(r"-> tuple(?=:)", "-> tuple[Any, ...]", text)
    text = re.sub(r"-> dict(?=:)", "-> dict[str, Any]", text)
    imports = "from typing import Annotated" if "Annotated[" in text else ""
    text = text.replace(imports, f"{imports}, Any", 1) if "Any" in text and imports else text
    lines = [wrapped for line in text.splitlines() for wrapped in _wrap(line)]
    return HEADER + "\n".join(lines).rstrip() + "\n"


def _array(found: re.Match[str]) -> str:
    array, shape = found.groups()
    if shape is None:
        return array
    sizes = ["*" if size == "None" else size for size in re.split(r",\s*", shape) if size]
    return f'Annotated[{array}, "({", ".join(sizes)}{"," if len(sizes) == 1 else ""})"]'


def _wrap(line: str) -> list[str]:
    """A signature that is too long, one parameter to a line."""
    if len(line) <= LINE or not line.lstrip().startswith("def "):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    start = line.index("(") + 1
    depth, quoted, parameters, here = 1, False, [], start
    for at in range(start, len(line)):
        mark = line[at]
        quoted ^= mark == '"'
        depth += 0 if quoted else (mark in "([{") - (mark in ")]}")
        if depth == 0 or (depth == 1 and mark == "," and not quoted):
            parameters.append(line[here:at].strip())
            here = at + 1
        if depth == 0:
            break
    body = [f"{indent}    {parameter}," for parameter in parameters]
    return [line[:start], *body, f"{indent}{line[at:]}"]


if __name__ == "__main__":
    sys.exit(main())
