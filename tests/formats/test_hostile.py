"""Files made to hang, fill or kill the process that reads them: one message each, soon, in little.

All are opened in one process of their own: the attack that kills it has no line, and those after it
neither.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from support.files.hostile import ATTACKS, HARMLESS
from support.paths import TESTS

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX"),
    pytest.mark.slow,
]

#: What an attack may take: of a processor, by the clock [s], of memory [MB]; and all of them [s].
WORK, SECONDS, MEGABYTES, ALL = 5.0, 60.0, 1000.0, 600.0
NAMES = [name for attacks in ATTACKS.values() for name in attacks]


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile")
    paths = (*filter(None, sys.path), str(TESTS))
    command = [sys.executable, "-m", "support.files.open_hostile", str(folder)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=ALL, check=False
        )
        output = done.stdout
    except subprocess.TimeoutExpired as error:
        output = error.stdout or b""
    lines = [json.loads(line) for line in output.splitlines() if line.endswith(b"}")]
    return {line["name"]: line for line in lines}


@pytest.mark.parametrize("name", [*NAMES, *HARMLESS])
def test_soon_and_in_little_memory(answers, name):
    assert name in answers, "it, or one before it, ended or held up the process"
    assert answers[name]["work"] < WORK
    assert answers[name]["seconds"] < SECONDS  # nothing is waited for
    assert answers[name]["megabytes"] < MEGABYTES


@pytest.mark.parametrize("name", NAMES)
def test_one_message_of_ours(answers, name):
    answer = answers[name]
    assert answer["error"] == "ours", answer
    assert "\n" not in answer["said"]
    assert len(answer["said"]) < 700


@pytest.mark.parametrize("name", HARMLESS)
def test_what_is_beside_a_mesh_is_not_opened(answers, name):
    """Materials and textures are no part of a shape."""
    assert answers[name]["error"] == "nothing", answers[name]
