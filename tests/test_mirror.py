"""`tests/` mirrors `src/`: from any source file its tests are found by name."""

from __future__ import annotations

import ast
import re

from support.covered_by import COVERED_BY, covering, lines, own_test, sources
from support.paths import ROOT, TESTS

#: Folders of tests that mirror no folder of src, each with its reason.
OTHERS = {
    "assets": "the data files of src/halfphysics/assets",
    "campaigns": "long campaigns, and a sample of each (campaigns/README.md)",
    "evidence": "mirrors evidence/ at the root",
    "examples": "mirrors examples/ at the root",
    "js": "mirrors js/ at the root: packages for browsers and node",
    "native": "mirrors src/native",
    "soft": "judges of soft layers through the public API, by closed forms and foreign code",
    "support": "mirrors src/halfphysics/support, and tests of what the tests share",
    "tools": "mirrors tools/ at the root",
}
#: Test files at the root of tests: about the package as a whole.
WHOLE = {
    "test_api.py",
    "test_docs.py",
    "test_layers.py",
    "test_mirror.py",
    "test_packaging.py",
    "test_printed.py",
}


def files_of_tests():
    return sorted(p.relative_to(TESTS) for p in TESTS.rglob("test_*.*") if p.suffix != ".pyc")


def test_every_folder_of_tests_is_one_of_the_sources():
    for path in files_of_tests():
        if len(path.parts) == 1:
            assert path.name in WHOLE
            continue
        top = path.parts[0]
        if top == "native":
            assert (ROOT / "src" / path.parent).is_dir(), path
        elif top not in OTHERS:
            assert (ROOT / "src" / "halfphysics" / path.parent).is_dir(), path
    assert {path.parts[0] for path in files_of_tests()} >= set(OTHERS), "stale"


def test_every_source_file_has_tests():
    assert [source for source in sources() if not covering(source)] == []


def test_every_line_of_the_list_is_needed():
    """Each is listed for a source file that has no tests of its name."""
    needed = {line for source in sources() if not own_test(source) for line in lines(source)}
    assert set(COVERED_BY) - needed == set()


def test_every_test_in_the_list_is_there():
    listed = {test for tests in COVERED_BY.values() for test in tests.split()}
    assert sorted(test for test in listed if not (TESTS / test).is_file()) == []


def test_no_test_file_imports_from_another():
    """What several tests share is in `tests/support`."""
    for path in TESTS.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if re.search(r"\bfrom\s+\S*test_", text) is None:
            continue  # parsing all of them takes seconds
        tree = ast.parse(text)
        modules = [n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
        found = [m for m in modules if m.rpartition(".")[2].startswith("test_")]
        assert not found, f"{path.relative_to(TESTS)} imports from {', '.join(found)}"
