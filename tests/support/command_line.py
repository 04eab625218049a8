"""The command line, called in this process."""

from __future__ import annotations

from halfphysics.cli import main


def run(*arguments):
    return main([str(argument) for argument in arguments])
