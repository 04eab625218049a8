"""Messages of the package in the words of the command line: all that a command can print."""

from __future__ import annotations

import ast

import pytest

import halfphysics as hp
from halfphysics.cli import simulate, sweep
from halfphysics.cli.wording import Voice, options_of, words_of
from support.paths import ROOT
from support.python_names import python_names

SOURCE = ROOT / "src" / "halfphysics"
SIMULATE = Voice(options_of(simulate.Command))
PLAN = Voice(options_of(sweep.Command), plan=True)

#: Messages that only a program in Python can meet, by module, and why.
PYTHON_ONLY = {
    "baselines/engine/geoms.py": "a shape of a class of the caller's",
    "body/body.py": "arrays and poses of the caller",
    "body/mjcf_person.py": "an MjSpec of the caller",
    "labels/": "functions that no command calls with values of its own",
    "metrics/sequences.py": "reports of the caller",
    "mujoco/": "a world of the caller",
    "results/dataset.py": "Result.to_xarray",
    "results/person_result.py": "a person that was taken out of its result",
    "simulation/holding.py": "Simulator.attach",
    "simulation/live_edits.py": "changes of a running Simulator",
    "simulation/simulate_many.py": "jobs of the caller",
    "simulation/simulator.py": "a Simulator",
}
#: Text that is no message: what is written into files, and what a page runs.
NO_MESSAGES = {
    "bench/": "scripts",
    "cli/wording.py": "the table itself",
    "sweep/store/card_page.py": "the page of a data set, which shows how Python reads it",
}


def messages():
    """Every text of several words in the sources that is no docstring; values in it are 7."""
    for path in sorted(SOURCE.rglob("*.py")):
        name = path.relative_to(SOURCE).as_posix()
        if any(name.startswith(known) for known in (*PYTHON_ONLY, *NO_MESSAGES)):
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docs = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            whole = text_of(node)
            if node not in docs and whole is not None and whole.count(" ") > 2:
                yield f"{name}:{node.lineno}", whole


def text_of(node):
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if not isinstance(node, ast.JoinedStr):
        return None
    return "".join(
        part.value if isinstance(part, ast.Constant) else value_of(part) for part in node.values
    )


def value_of(part):
    """A name of a class where one is written; quotes where repr writes them."""
    if "__name__" in ast.unparse(part):
        return "EngineVelocity"
    return "'it'" if part.conversion == ord("r") else "7"


def test_no_message_speaks_python():
    found = dict(messages())
    assert len(found) > 1000  # of about 1,600: the search finds what there is
    wrong = {
        place: said
        for place, text in found.items()
        if python_names(said := words_of(text, SIMULATE))
    }
    assert wrong == {}


def test_every_exception_is_needed():
    texts = {
        path.relative_to(SOURCE).as_posix(): path.read_text(encoding="utf-8")
        for path in SOURCE.rglob("*.py")
    }
    for known in (*PYTHON_ONLY, *NO_MESSAGES):
        assert any(name.startswith(known) for name in texts), known


@pytest.mark.parametrize(
    ("python", "command"),
    [
        ("Say it with fps=, for example fps=30", "Say it with --fps, for example --fps 30"),
        ("Then say up='-y' (up='z': it is)", "Then say --up=-y (--up=z: it is)"),
        ("read others with frames=(start, stop)", "read others with --frames START:STOP"),
        ("leave it out with frames=(3, None)", "leave it out with --frames 3:"),
        ("read the motion alone with Motion.load", "read the motion alone with --objects none"),
        ("Settings.drive_time is None; expected", "--drive-time is none; expected"),
        ("Torque.frequency is -1.0; expected", "--torque-frequency is -1.0; expected"),
        ("keep it with allow_mismatch=True", "keep it with --allow-mismatch"),
        ("one is put there (ground=False: none)", "one is put there (--no-ground: none)"),
        ("a Plane has no volume, expected Box", "a plane has no volume, expected box"),
        ("fps: found -1, expected", "--fps: found -1, expected"),
        (
            "Settings.strength is {'arms': 40.0, 'legs': 1.5}; expected None without drive_time",
            "--strength is arms=40,legs=1.5; expected none without --drive-time",
        ),
        (
            "a.txt: no known motion format. Found a file that begins with b'a: [1]\\n'. Expected "
            "one of: bvh: text; gltf: a 'skin'",
            "a.txt: no known motion format. Found a file that begins with 'a: [1]\\n'. Expected "
            "a motion file; halfphysics formats lists those that are read",
        ),
        ("say motion.resample(20)", "say --to-fps 20 of halfphysics convert"),
    ],
)
def test_the_same_message_as_options(python, command):
    assert words_of(python, SIMULATE) == command


def test_a_plan_has_keys_in_place_of_options():
    assert words_of("Say it with fps=, such as fps=30", PLAN) == "Say it with fps, such as fps: 30"
    assert words_of("Settings.stiffness is -3; expected", PLAN) == "stiffness is -3; expected"


@pytest.mark.parametrize(
    "text",
    [
        "found 'up=q', expected",
        "object 'Box=box:1:1:1,up=None': key",
        "rooms/up=y/Motion.npz: no such file",
        "a file of SAM 3D Body, HY-Motion or Motion-X",
        "expected mass= [kg] or density= [kg/m^3], found both",
    ],
)
def test_what_a_user_wrote_stays(text):
    """Quoted, or a path; keys of an object are no options, names of projects no classes."""
    assert words_of(text, SIMULATE) == text


def test_options_of_nested_dataclasses():
    named = options_of(simulate.Command)
    assert {"fps", "stiffness", "torque_damping", "scene", "body", "out", "motions"} <= named
    assert "person" not in named  # a group


def test_python_names_are_found():
    """The judge of these tests sees each kind."""
    for text in (
        "Raises InputError", "see Motion.load(path)", "a Scene", "hp.simulate", "None", "is True",
        "PosixPath('x')", "JOINT_GROUPS", "load_sequence reads it", "with fps=30", 
        "halfphysics.fix", "<class 'int'>", "array([1.0])",
    ):  # fmt: skip
        assert python_names(text), text
    for text in (
        "halfphysics simulate walk.npz", "motion capture", "--fps 30",
        "global_orient (T, 3)", "ball=sphere:0.11,mass=0.43", "none of them", "MuJoCo",
    ):  # fmt: skip
        assert not python_names(text), text
    assert "simulate_many" in hp.__all__  # a name that is looked for
