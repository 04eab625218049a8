"""Help as plain text: all that a command takes, in the width of the terminal, without Python."""

from __future__ import annotations

import importlib
import re

import pytest

from halfphysics.cli import COMMANDS
from halfphysics.cli.help_page import EVERYWHERE, help_page, parsed
from halfphysics.cli.wording import options_of
from support.command_line import run
from support.python_names import python_names

#: Commands whose options are a dataclass; `scenario NAME` makes its own.
WITH_OPTIONS = [name for name in COMMANDS if name != "scenario"]
PAGES = [[], *([name] for name in COMMANDS), ["scenario", "kick_ball"]]

BOXES = """\
usage: hp walk [-h] [OPTIONS] FILE

Walk about.

Where to is
said here.

╭─ positional arguments ─────────────────────────╮
│ FILE        A file. (required)                 │
╰────────────────────────────────────────────────╯
╭─ options ──────────────────────────────────────╮
│ -h, --help  show this help message and exit    │
│ -o FILE, --out FILE                            │
│             What to write, in a                │
│             file. (default: none)              │
╰────────────────────────────────────────────────╯
╭─ way-there options ────────────────────────────╮
│ How to go. Raises InputError if impossible.    │
│ ────────────────────────────────────────────── │
│ --speed NUMBER                                 │
│             In m/s; None: as it is. (default:  │
│             none)                              │
│ --far, --no-far                                │
│             Go far. (default: True)            │
╰────────────────────────────────────────────────╯
"""


def test_boxes_become_plain_text(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    everywhere = "\n".join(f"  {name.ljust(22)}{text}" for name, text in EVERYWHERE[:2])
    page = help_page(BOXES, "hp walk x\n")
    assert page.startswith(
        "usage: hp walk [OPTIONS] FILE\n\nWalk about.\n\nWhere to is said here.\n\n"
        "arguments:\n  FILE                  A file.\n\n"
        f"options:\n  -o, --out FILE        What to write, in a file.\n{everywhere}\n"
    )
    assert page.endswith(
        "way there: how to go.\n"
        "  --speed NUMBER        In m/s; if not given: as it is.\n"
        "  --far, --no-far       Go far. (default: yes)\n\n"
        "examples:\n  hp walk x\n"
    )


def test_boxes_are_taken_apart():
    usage, description, sections = parsed(BOXES)
    assert usage == "usage: hp walk [OPTIONS] FILE"
    assert description == ["Walk about.", "Where to is said here."]
    assert [(s.title, len(s.entries)) for s in sections] == [
        ("positional arguments", 1),
        ("options", 2),
        ("way-there options", 2),
    ]


def sentences(text):
    """Paragraphs, and what each option means without the option itself."""
    for block in text.split("\n\n"):
        for entry in re.split(r"^  (?=\S)", block, flags=re.MULTILINE):
            yield " ".join(entry.split("   ", 1)[-1].split())


@pytest.mark.parametrize("arguments", PAGES, ids=" ".join)
def test_help_speaks_no_python_and_fits(arguments, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert run(*arguments, "--help") == 0
    out, err = capsys.readouterr()
    assert err == ""
    text, _, examples = out.partition("\nexample")
    assert examples
    for sentence in sentences(text):
        assert python_names(sentence) == [], sentence
    assert [line for line in text.splitlines() if len(line) > 80] == []
    assert not re.search("[╭│╰`]|firm|peer", text)


@pytest.mark.parametrize("name", WITH_OPTIONS)
def test_help_has_every_option_with_a_sentence(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    command = importlib.import_module(f"halfphysics.cli.{name}").Command
    run(name, "--help")
    out = capsys.readouterr().out
    entries = re.split(r"^  (?=\S)", out.partition("\nexamples:")[0], flags=re.MULTILINE)[1:]
    flags = {flag for entry in entries for flag in re.findall(r"--[\w-]+", entry.split("   ")[0])}
    positional = {"motion", "motions", "file", "files", "what", "where", "plan"}
    positional |= {"source", "target"}
    expected = {f"--{option.replace('_', '-')}" for option in options_of(command)}
    missing = expected - flags
    assert {flag[2:] for flag in missing} <= positional, missing
    for entry in (entry.split("\n\n")[0] for entry in entries):
        assert re.search(r"\w{3,}.*[.)]$", " ".join(entry.split())), entry
