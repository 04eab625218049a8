"""Everything printed works: blocks of Python and lines of the shell, run as they are printed.

The blocks of one document run in their order, in one folder and one namespace, with no optional
package but those that the document says to install.
"""

from __future__ import annotations

import ast
import logging
import re
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from halfphysics.cli import serve
from halfphysics.live.client import connect
from halfphysics.scene.scene import Scene
from halfphysics.sweep import Plan
from halfphysics.viewer.served import Served
from support.paths import ROOT
from support.printed import installed
from support.printed.blocks import blocks_of, commands_in_sentences, documents
from support.printed.files import names, write_carry, write_files
from support.printed.shell import READ_ONLY, lines_of, read_command, read_mention, run_line

#: Languages of blocks: how each is held.
LANGUAGES = {"python", "sh", "js", "ts", "yaml", "text", "math", "bibtex", "bat"}
#: Lines that are not run, and why. Each must still be printed somewhere.
NOT_RUN = {
    "ssh -L 8080:127.0.0.1:8080 user@machine        # then open http://127.0.0.1:8080 at home": (
        "needs another machine"
    ),
    "halfphysics sweep plan.yaml --out /shared/data --engine ray --address auto": (
        "needs a cluster of Ray; tests/sweep starts one of this machine"
    ),
    "halfphysics view ws://127.0.0.1:8765    # people, reference, objects and contacts of "
    "`halfphysics serve`": "needs a live session; tests/viewer/test_live_view.py has one",
    "halfphysics play ws://127.0.0.1:8765    # and drag its objects, change their masses and "
    "frictions": "needs a live session; tests/viewer/test_live_view.py has one",
    "halfphysics sweep plan.yaml --engine ray --address auto": "needs a cluster of Ray",
    **dict.fromkeys(
        (
            "cmake -S . -B build/c -DHALFPHYSICS_PYTHON=OFF -DHALFPHYSICS_C=ON",
            "cmake --build build/c",
            "cmake --install build/c --prefix out/halfphysics",
            "python examples/c/write_world.py out/kick.hpw out/kick.poses",
            "cc -std=c99 -Iout/halfphysics/include examples/c/walk.c -Lout/halfphysics/lib "
            "-lhalfphysics -o out/walk",
            "LD_LIBRARY_PATH=out/halfphysics/lib out/walk out/kick.hpw out/kick.poses 300",
        ),
        "compiles the core; tests/native/capi/test_library.py does the same",
    ),
    "ray job submit --address http://head:8265 --runtime-env-json "
    """'{"pip": ["halfphysics[ray]==0.1.0"]}' """
    "-- halfphysics sweep /shared/plan.yaml --out /shared/data --engine ray": (
        "needs a cluster of Ray"
    ),
}
#: Documents that take over five seconds of one core.
SLOW = {"README.md", "docs/pictures.md"}
DOCUMENTS = [path.relative_to(ROOT).as_posix() for path in documents()]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory) -> Path:
    """The files of which the documents speak, made once."""
    folder = tmp_path_factory.mktemp("prepared")
    write_files(folder)
    return folder


@pytest.fixture
def folder(prepared, tmp_path, monkeypatch) -> Path:
    """An own copy of them, as the current folder."""
    for path in prepared.rglob("*"):
        target = tmp_path / path.relative_to(prepared)
        if path.is_dir():
            target.mkdir(parents=True)
        else:
            target.write_bytes(path.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def logs() -> Iterator[None]:
    """A document that shows how to log changes it for itself alone."""
    loggers = [logging.getLogger(name) for name in (None, "halfphysics")]
    before = [(logger.level, logger.handlers[:]) for logger in loggers]
    yield
    for logger, (level, handlers) in zip(loggers, before, strict=True):
        logger.setLevel(level)
        logger.handlers[:] = handlers


@pytest.fixture
def served(monkeypatch) -> list[str]:
    """Instead of waiting for Ctrl-C a server is asked for its page, and stopped."""
    answered = []

    def ask(self) -> None:
        with urllib.request.urlopen(self.url, timeout=20.0) as reply:
            assert reply.status == 200
            assert b"<html" in reply.read(2000)
        answered.append(self.url)
        self.stop()

    def ask_live(self, live) -> None:
        with connect(live.url) as client:
            assert client.receive(20.0).poses
        answered.append(live.url)

    monkeypatch.setattr(Served, "wait", ask)
    monkeypatch.setattr(serve.Command, "_wait", ask_live)
    return answered


@pytest.mark.parametrize("document", DOCUMENTS)
def test_blocks_say_their_language(document):
    unknown = [b.name for b in blocks_of(ROOT / document) if b.language not in LANGUAGES]
    assert not unknown, f"expected one of {sorted(LANGUAGES)}"


@pytest.mark.parametrize("document", DOCUMENTS)
def test_no_heading_is_there_twice(document):
    text = (ROOT / document).read_text(encoding="utf-8")
    for block in blocks_of(ROOT / document):
        text = text.replace(block.text, "")
    headings = re.findall(r"^#{1,6} .*$", text, re.MULTILINE)
    assert len(headings) == len(set(headings))


def runnable(document):
    return [b for b in blocks_of(ROOT / document) if b.language in ("python", "sh", "yaml")]


def marked(document):
    """A document that takes seconds is marked as slow."""
    marks = [pytest.mark.slow] if document in SLOW else []
    return pytest.param(document, marks=marks)


@pytest.mark.filterwarnings("default::halfphysics.errors.HalfPhysicsWarning")
@pytest.mark.parametrize("document", [marked(d) for d in DOCUMENTS if runnable(d)])
def test_blocks_run_as_printed(document, folder, served, monkeypatch, request):
    text = (ROOT / document).read_text(encoding="utf-8")
    if "captured_objects" in text:
        write_carry(folder, request.getfixturevalue("carried_file"))
    known = names(folder)
    with installed.only(installed.said(text), monkeypatch):
        for block in runnable(document):
            try:
                RUN[block.language](block, known)
            except Exception as error:
                error.add_note(f"in {block.name}")
                raise


def run_python(block, known):
    tree = ast.parse(block.text, block.name)
    exec(compile(ast.increment_lineno(tree, block.line - 1), block.name, "exec"), known)


def run_shell(block, known):
    for line in lines_of(block.text):
        if line not in NOT_RUN:
            run_line(line)


def read_yaml(block, known):
    path = Path("printed.yaml")
    path.write_text(block.text, encoding="utf-8")
    if re.search(r"^inputs:", block.text, re.MULTILINE):
        assert Plan.load(path).inputs
    else:
        scene = Scene.load(path)
        assert [*scene.statics, *scene.objects, *scene.articulated]


RUN = {"python": run_python, "sh": run_shell, "yaml": read_yaml}


@pytest.mark.parametrize("document", [d for d in DOCUMENTS if commands_in_sentences(ROOT / d)])
def test_commands_in_sentences_can_be_read(document, folder, capsys):
    for command in commands_in_sentences(ROOT / document):
        read_mention(command.split()[1:])


def test_the_lists_of_what_is_not_run_are_not_stale():
    printed = [
        line
        for path in documents()
        for block in blocks_of(path)
        if block.language == "sh"
        for line in lines_of(block.text)
    ]
    assert set(NOT_RUN) <= set(printed)
    for command in READ_ONLY:
        assert any(line.startswith(f"halfphysics {command}") for line in printed)


#: What code in a docstring begins with.
CODE = (">>>", "```")


def docstrings_with_code():
    """(place, text) of those of the package and of the examples."""
    for top in ("src/halfphysics", "examples"):
        for path in sorted((ROOT / top).rglob("*.py")):
            source = path.read_text(encoding="utf-8")
            if not any(mark in source for mark in CODE):
                continue
            for node in ast.walk(ast.parse(source)):
                if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                    said = ast.get_docstring(node)
                    if said and any(mark in said for mark in CODE):
                        yield path.relative_to(ROOT).as_posix(), said


def test_docstrings_print_no_code_that_nothing_runs():
    """Their code would be run by nothing: it stands in the documents and in examples/."""
    assert not list(docstrings_with_code())


def test_the_examples_of_commands_can_be_read(folder, capsys):
    """Every line of `EXAMPLES`, which --help prints."""
    import importlib

    from halfphysics.cli import COMMANDS

    for command in COMMANDS:
        module = importlib.import_module(f"halfphysics.cli.{command}")
        for line in lines_of(module.EXAMPLES):
            assert line.startswith(f"halfphysics {command}")
            read_command(re.sub(r"\s#.*", "", line).split()[1:])
