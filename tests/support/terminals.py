"""A standard error that is a terminal, whose text can be read."""

from __future__ import annotations

import io
import sys


class Terminal(io.StringIO):
    """Text, as it was written to a terminal."""

    def isatty(self):
        return True


def terminal(monkeypatch):
    """Put a terminal in place of standard error."""
    made = Terminal()
    monkeypatch.setattr(sys, "stderr", made)
    return made
