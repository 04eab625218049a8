"""References in the documents and the comments are to existing files."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

import halfphysics as hp

ROOT = Path(__file__).resolve().parents[1]
#: A source or a document in backquotes, with enough of its path to identify it.
FILE = re.compile(r"`([\w./-]+\.(?:py|cpp|h|md))`")
#: A document named in a comment, or a link from one document to another.
DOCUMENT = re.compile(r"\bdocs/(?:tutorials/)?[\w-]+\.md\b")
#: Names of files that a reader writes, not files of the repository.
EXAMPLES = {"NAME.py", "my_format.py", "card.md"}


def tracked() -> list[str]:
    """The files of the repository; without git (an unpacked sdist) there is nothing to compare."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [line for line in listed.stdout.splitlines() if (ROOT / line).is_file()]


def documents() -> list[str]:
    found = (path.relative_to(ROOT).as_posix() for path in sorted(ROOT.glob("docs/**/*.md")))
    return ["README.md", "CONTRIBUTING.md", *found]


@pytest.mark.parametrize("document", documents())
def test_files_that_a_document_names_exist(document):
    files = tracked()
    text = (ROOT / document).read_text(encoding="utf-8")
    named = set(FILE.findall(text)) - EXAMPLES
    missing = [
        name
        for name in sorted(named)
        if Path(name).name not in EXAMPLES
        and not any(file == name or file.endswith(f"/{name}") for file in files)
    ]
    assert not missing, f"{document} names files that do not exist"


def test_documents_that_a_source_names_exist():
    missing = {}
    for file in tracked():
        if not file.endswith((".py", ".cpp", ".h", ".md", ".toml", ".sh")):
            continue
        if file == "CHANGELOG.md":  # names files of earlier versions
            continue
        text = (ROOT / file).read_text(encoding="utf-8")
        gone = {name for name in DOCUMENT.findall(text) if not (ROOT / name).is_file()}
        if gone:
            missing[file] = sorted(gone)
    assert not missing


def test_the_version_to_cite_is_this_one():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == hp.__version__
    assert {"cff-version", "message", "title", "authors"} <= set(cited)
    bibtex = (ROOT / "docs" / "citing.md").read_text(encoding="utf-8")
    assert f"version = {{{hp.__version__}}}" in bibtex
    paper = cited["references"][0]
    assert paper["title"].replace("3D", "{3D}") in bibtex
    assert paper["url"].rpartition("/")[2] in bibtex


def test_issue_templates_are_forms():
    for path in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"):
        form = yaml.safe_load(path.read_text(encoding="utf-8"))
        if path.name == "config.yml":
            continue
        assert {"name", "description", "body"} <= set(form), path.name
        ids = [field["id"] for field in form["body"]]
        assert len(ids) == len(set(ids))
        assert all(field["attributes"]["label"] for field in form["body"])


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash expands the list")
def test_the_tests_that_run_under_sanitizers_exist():
    script = (ROOT / "tools/sanitize.sh").read_text(encoding="utf-8")
    listed = re.findall(r"tests/[\w/{},]+\.py", script)
    expanded = subprocess.run(
        ["bash", "-c", f"printf '%s\\n' {' '.join(listed)}"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert expanded
    assert not [name for name in expanded if not (ROOT / name).is_file()]
