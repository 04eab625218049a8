"""Tables of the command line."""

from __future__ import annotations

from halfphysics.cli.table import table


def test_table():
    assert table([("", "a"), ("long name", "1"), ("x", "22.5")]) == (
        "              a\n---------  ----\nlong name     1\nx          22.5"
    )
