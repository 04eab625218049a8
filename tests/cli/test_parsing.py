"""One message taken from a framed box."""

from __future__ import annotations

from halfphysics.cli.parsing import one_message


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
        "unknown option --stif; did you mean --stiffness? hp simulate --help explains the options"
    )
