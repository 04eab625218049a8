"""The site of the documents: every public name is in the reference, every page in the contents."""

from __future__ import annotations

import importlib
import inspect
import re
import sys
from pathlib import Path

import pytest

import halfphysics as hp
from support.paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import build_site


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "source"
    build_site.stage(folder)
    return folder


@pytest.fixture(scope="module")
def entries(source) -> set[str]:
    """The names that the pages of the reference have an entry for."""
    found = set()
    for page in (source / "reference").glob("*.rst"):
        text = page.read_text(encoding="utf-8")
        found |= set(re.findall(r"^\.\. auto\w+:: ([\w.]+)$", text, re.MULTILINE))
        data = re.findall(r"^\.\. py:data:: (\w+)\n   :module: ([\w.]+)$", text, re.MULTILINE)
        found |= {f"{module}.{name}" for name, module in data}
    return found


def test_every_public_name_has_an_entry(entries):
    names = {f"halfphysics.{name}" for name in hp.__all__ if not name.startswith("__")}
    assert names - entries == set()
    for module in build_site.MODULES:
        found = importlib.import_module(module)
        for name in build_site.public(found):
            value = getattr(found, name)
            also = [n for n in hp.__all__ if getattr(hp, n) is value]
            assert {f"{module}.{name}", *(f"halfphysics.{n}" for n in also)} & entries, name


def test_every_public_module_has_a_page():
    modules = {f"halfphysics.{name}" for name in hp.__all__ if inspect.ismodule(getattr(hp, name))}
    assert modules <= set(build_site.MODULES)


def test_every_document_is_in_the_contents(source):
    home = (source / "index.md").read_text(encoding="utf-8")
    listed = {
        line
        for tree in re.findall(r"```{toctree}(.*?)```", home, re.DOTALL)
        for line in tree.split()
    }
    pages = {p.relative_to(source).with_suffix("").as_posix() for p in source.rglob("*.md")}
    below = {page for page in pages if page.startswith("tutorials/")} - {"tutorials/index"}
    assert pages - below - {"index"} <= listed
    tutorials = (source / "tutorials" / "index.md").read_text(encoding="utf-8")
    assert all(f"\n{page.removeprefix('tutorials/')}\n" in tutorials for page in below)


def test_links_between_documents_hold_on_github():
    """In the repository: a link is to a file that is there, and to a heading of it."""
    for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]:
        text = re.sub(r"```.*?^ *```", "", path.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
        text = re.sub(r"`[^`\n]*`", "", text)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if "://" in target:
                continue
            name, _, anchor = target.partition("#")
            file = (path.parent / name).resolve() if name else path
            assert file.exists(), f"{path.name}: {target}"
            if anchor:
                assert anchor in anchors(file), f"{path.name}: {target}"


def anchors(path: Path) -> set[str]:
    """The anchors that GitHub gives to headings."""
    found = set()
    for head in re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE):
        kept = re.sub(r"[^\w\- ]", "", head.lower())
        found.add(kept.strip().replace(" ", "-"))
    return found


@pytest.mark.slow
def test_the_site_is_built_without_a_warning(tmp_path):
    pytest.importorskip("furo", reason="builds with the extra docs: ./run docs")
    assert build_site.main([str(tmp_path / "site")]) == 0
    home = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    assert not re.findall(r"<(?:script|link)[^>]*(?:src|href)=.https?:", home)  # nothing from afar
