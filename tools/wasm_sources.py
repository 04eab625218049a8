"""Which sources the core for browsers is made of, and their hash: used by tools/build_wasm.sh and tests.

python tools/wasm_sources.py --list     # the .cpp files, one a line
python tools/wasm_sources.py --hash     # SHA-256 of all that the .wasm depends on
python tools/wasm_sources.py --key FILE FLAGS   # of one object file
"""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NATIVE = ROOT / "src" / "native"
#: Folders of src/native that are compiled; what in them only Python needs is left out.
FOLDERS = (
    "math", "dynamics", "geometry", "contact", "collision", "soft", "footing", "stepping",
    "stepping/baselines", "assembly", "compiled", "capi",
)  # fmt: skip
LEFT_OUT = {"geometry/skinning.cpp", "geometry/point_queries.cpp"}


def sources() -> list[Path]:
    """The .cpp files, sorted."""
    found = sorted(path for folder in FOLDERS for path in (NATIVE / folder).glob("*.cpp"))
    return [path for path in found if path.relative_to(NATIVE).as_posix() not in LEFT_OUT]


def digest(files: list[Path], more: str = "") -> str:
    """SHA-256 of names and contents, line ends as on Linux."""
    total = hashlib.sha256(more.encode())
    for path in files:
        total.update(path.relative_to(ROOT).as_posix().encode() + b"\0")
        total.update(path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return total.hexdigest()


def headers() -> list[Path]:
    """All headers of the folders."""
    found = (path for folder in FOLDERS for path in (NATIVE / folder).glob("*.h"))
    return sorted([*found, NATIVE / "tuning.h"])


def everything() -> str:
    """Hash of all that the compiled core depends on."""
    return digest([*sources(), *headers(), ROOT / "tools" / "build_wasm.sh"])


def main() -> None:
    """See above."""
    match sys.argv[1:]:
        case ["--list"]:
            print(*(path.relative_to(ROOT).as_posix() for path in sources()), sep="\n")
        case ["--hash"]:
            print(everything())
        case ["--key", file, flags]:
            print(digest([ROOT / file, *headers()], flags))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
