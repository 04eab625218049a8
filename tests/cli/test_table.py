"""What the commands are made of: tables, and one message out of a framed box."""

from __future__ import annotations

from halfphysics.cli.parsing import one_message
from halfphysics.cli.table import table


def test_table():
    assert table([("", "a"), ("long name", "1"), ("x", "22.5")]) == (
        "              a\n---------  ----\nlong name     1\nx          22.5"
    )


def test_one_message_from_a_box():
    box = (
        "╭─ Unrecognized options ─────╮\n"
        "│ \x1b[1mUnrecognized\x1b[0m options: │\n"
        "│ --stif, 3                  │\n"
        "│ ────────────────────────── │\n"
        "│ Perhaps you meant:         │\n"
        "│     --stiffness FLOAT      │\n"
        "│         Firmness           │\n"
        "│ ────────────────────────── │\n"
        "│ For full helptext, run x   │\n"
        "╰────────────────────────────╯\n"
    )
    assert one_message(box, "hp simulate") == (
        "Unrecognized options: --stif, 3. Perhaps you meant: --stiffness FLOAT. "
        "hp simulate --help explains the options"
    )
