"""Fixtures shared by the tests."""

from __future__ import annotations

import gc
import os
import signal
import sys
from pathlib import Path

import hypothesis
import pytest

from support.paths import ROOT

# The time limits of hypothesis are off: the machine's load says nothing about the code.
hypothesis.settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("any machine")

# What a shell starts in its background ignores Ctrl-C, and so do its children: tests that send it
# to a program would wait for ever.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish() -> None:
    """The collector of garbage need not look at thousands of tests each time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def kept_pieces(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The cache of decomposed meshes is in a folder of this run, not in the home folder."""
    os.environ["HALFPHYSICS_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with real motions and meshes; tests that use it skip if it is absent."""
    default = ROOT.parent / "shared" / "data"
    folder = Path(os.environ.get("HALFPHYSICS_TEST_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no test data at {folder} (set HALFPHYSICS_TEST_DATA)")
    return folder


@pytest.fixture(scope="session")
def carried_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of OMOMO with a suitcase that is carried, and the mesh beside it."""
    from support.carries.cases import all_cases
    from support.carries.files.omomo import write_omomo
    from support.carries.recordings import recording

    made = recording(next(case for case in all_cases() if case.thing == "suitcase"))
    return write_omomo([made], tmp_path_factory.mktemp("carried"))


def pytest_terminal_summary(terminalreporter) -> None:
    """Print the fuzzer's counts, if HALFPHYSICS_FUZZ is set."""
    fuzzing = sys.modules.get("support.fuzzing")
    if fuzzing is not None and fuzzing.SECONDS > 0.0 and fuzzing.seen:
        terminalreporter.section("fuzzed")
        for line in fuzzing.report():
            terminalreporter.write_line(line)
