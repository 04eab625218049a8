"""The committed stubs of the extensions agree with the compiled modules."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

pytest.importorskip("nanobind")

TOOL = Path(__file__).resolve().parents[2] / "tools" / "make_stubs.py"


@pytest.fixture(scope="module")
def tool():
    spec = importlib.util.spec_from_file_location("make_stubs", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["_native", "_render"])
def test_the_stubs_are_current(tool, name):
    """If not: build in place, and run tools/make_stubs.py."""
    assert tool.path_of(name).read_text(encoding="utf-8") == tool.stub(name)


def test_long_signatures_are_wrapped(tool):
    parameters = 'self, first: Annotated[X, "(*, 3)"], second: dict[str, int] = (1, 2)'
    wrapped = tool._wrap(f"    def a_name_of_some_length({parameters}) -> None: ...")
    assert wrapped == [
        "    def a_name_of_some_length(",
        "        self,",
        '        first: Annotated[X, "(*, 3)"],',
        "        second: dict[str, int] = (1, 2),",
        "    ) -> None: ...",
    ]
