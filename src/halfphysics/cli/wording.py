"""The package's messages in the words of the command line.

Errors and warnings are written once, for Python: they name arguments (``fps=30``), classes and
functions. Here each becomes what a command calls it: an option (``--fps 30``), a key of a plan, a
plain noun. Text that a user wrote stays as it is: all between quotes, and paths.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from typing import Any, get_args, get_type_hints


@dataclass(frozen=True)
class Voice:
    """How a command names what Python calls an argument.

    Attributes:
        options: The command's own options, as Python writes them (``drive_time``).
        plan: Whether arguments are keys of a plan file, as of ``sweep``.
    """

    options: Collection[str] = field(default=())
    plan: bool = False

    def named(self, name: str, value: str = "") -> str:
        """An argument, with a value if it has one."""
        if self.plan:
            return f"{name}: {value}" if value else name
        flag = name.replace("_", "-")
        if value in ("True", "False"):
            said = f"--{flag}" if value == "True" else f"--no-{flag}"
        elif name in _JOINED and value:
            said = f"--{flag}={value}"  # a value may begin with a minus
        else:
            said = f"--{flag} {'none' if value == 'None' else value}".rstrip()
        if name in self.options:
            return said
        return f"{said} of halfphysics {'convert' if name in _OF_FILES else 'simulate'}"


#: The voice of the command that runs, made when a message needs it.
_voice: ContextVar[Callable[[], Voice]] = ContextVar("voice", default=Voice)


def speak_as(voice: Callable[[], Voice]) -> None:
    """Let `spoken` name arguments as this voice does, until the next call."""
    _voice.set(voice)


def spoken(message: str) -> str:
    """A message of the package as the running command says it."""
    return words_of(message, _voice.get()())


def options_of(kind: Any) -> set[str]:
    """The names of a command's options, those of nested dataclasses included."""
    found: set[str] = set()
    hints = _hints(kind)
    for one in fields(kind):
        inner = hints[one.name]
        while get_args(inner) and not isinstance(inner, type):
            inner = get_args(inner)[0]
        if is_dataclass(inner):
            found |= options_of(inner)
        else:
            found.add(one.name.rstrip("_"))  # `for_`: words that Python keeps for itself
    return found


@cache  # a page of help asks for each of its lines
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def words_of(message: str, voice: Voice) -> str:
    """A message of the package as `voice` says it."""
    for pattern, text in _PHRASES:
        message = _outside(message, pattern, text)
    message = _outside(message, _MAPPING, _joined)
    message = _outside(message, _FIELD, lambda found: voice.named(_of_baseline(found[1])))
    message = _outside(message, _FLAG, lambda found: voice.named(found[1], found[2]))
    message = _outside(
        message,
        _ARGUMENT,
        lambda found: voice.named(found[1], found[2] or found[3] or found[4] or ""),
    )
    if not voice.plan:
        message = _outside(message, _BARE, lambda found: _bare(found[0], voice))
        message = _LEADING.sub(
            lambda found: (
                voice.named(found[0]) if found[0] in set(voice.options) - _POSITIONAL else found[0]
            ),
            message,
        )
    for pattern, text in _WORDS:
        message = _outside(message, pattern, text)
    return message


def _bare(name: str, voice: Voice) -> str:
    return voice.named(name) if name in voice.options else name


def _outside(message: str, pattern: re.Pattern[str], text: Any) -> str:
    """Replace a pattern everywhere but in what a user wrote."""
    if pattern.search(message) is None:
        return message
    given = re.compile(f"{_GIVEN}|(?P<hit>{pattern.pattern})")

    def replaced(found: re.Match[str]) -> str:
        if found["hit"] is None:
            return found[0]
        # A pattern may look at what is around it.
        inner = pattern.fullmatch(found["hit"]) or pattern.match(message, found.start())
        if inner is None:
            return found[0]
        return text(inner) if callable(text) else inner.expand(text)

    return given.sub(replaced, message)


#: Quoted text that is no argument's value, and paths with a folder in them.
_GIVEN = r"(?<![\w=])'[^']*'(?!\w)|(?<![^\s'])[^\s'\"=(]*[/\\][^\s'\"(]*"

#: Arguments of reading a motion file or making its body: every command that reads one has them.
_OF_FILES = frozenset(
    [
        "fps",
        "up",
        "floor",
        "hands",
        "model",
        "gender",
        "frames",
        "clip",
        "assets",
        "objects",
        "adapt",
        "grip",
        "body",
        "stature",
        "mass",
        "allow_mismatch",
        "format",
        "to_fps",
    ]
)
#: Arguments whose value may begin with a minus.
_JOINED = ("up", "floor")
#: Other arguments that messages name: of `halfphysics.Settings`, of baselines and of scenes.
_OTHERS = (
    "substeps stiffness drive_time recovery_rate weight blocked root root_speed clearance "
    "clearance_range contact self_contact depenetration_speed tolerance max_sweeps strength "
    "joint_limits soft_skin threads record mode internal_forces joint_damping torque_frequency "
    "torque_damping scene static object ground reference grounded size"
)
_NAMES = "|".join(sorted((_OF_FILES - {"mass"}) | set(_OTHERS.split()), key=len, reverse=True))
#: Fields of commands that are given by their place, without a name.
_POSITIONAL = frozenset(["motion", "motions", "file", "files", "what", "plan", "source", "target"])
#: A name of Python's with an underscore, which may be that of an option.
_BARE = re.compile(r"(?<![\w.\[{-])[a-z]+(?:_[a-z]+)+(?![\w(.=:])")
_LEADING = re.compile(r"^\w+(?=:| is )")

_VALUE = r"""'([^']*)'|"([^"]*)"|(-?\d[\w.]*|None|[A-Z][A-Z_]+\b)"""
_ARGUMENT = re.compile(rf"(?<![\w.,-])({_NAMES})=(?!=)(?:{_VALUE})?")
_FLAG = re.compile(
    r"(?<![\w.-])(ground|adapt|grip|weight|joint_limits|allow_mismatch)=(True|False)\b"
)
_SETTINGS = (
    "Settings|Ablation|Torque|Positions|Interpolated|Kinematic|EngineKinematic|EngineVelocity"
)
_FIELD = re.compile(rf"(?<!\w)(?:halfphysics\.|hp\.)?(?:{_SETTINGS})\.(\w+)(?!\()")


#: A mapping as Python writes it.
_MAPPING = re.compile(r"\{(?:'\w+': [-+.\de]+(?:, )?)+\}")


def _joined(found: re.Match[str]) -> str:
    """A mapping as options give it: arms=40,legs=0.2."""
    pairs = re.findall(r"'(\w+)': ([-+.\de]+)", found[0])
    return ",".join(f"{name}={float(number):g}" for name, number in pairs)


def _of_baseline(name: str) -> str:
    return {"frequency": "torque_frequency", "damping": "torque_damping"}.get(name, name)


def _compiled(table: Mapping[str, str]) -> list[tuple[re.Pattern[str], str]]:
    return [(re.compile(pattern), text) for pattern, text in table.items()]


#: Advice to call a function -> the same with options. In this order, longer ones first.
_PHRASES = _compiled(
    {
        # reading files
        r"Motion\.load\(\.\.\., frames=\(start, stop\)\)": "--frames START:STOP",
        r"frames=\(start, stop\)": "--frames START:STOP",
        r"frames=\((\d+), None\)": r"--frames \1:",
        r"(motion|person) alone with Motion\.load": r"\1 alone with --objects none",
        r"load_sequence reads both, Motion\.load one:": (
            "halfphysics simulate reads both, --objects none one:"
        ),
        r"load_sequence finds the object by itself": "its object is found by itself",
        r"load_sequence (reads|brings)": r"halfphysics simulate \1",
        r"; halfphysics\.clips\(path\) goes through them all": (
            "; halfphysics judge goes through them all"
        ),
        r"halfphysics\.clips\(path\) goes through a library": (
            "halfphysics judge goes through a folder of them"
        ),
        r"a mesh for a scene is read by Scene\.add_static": (
            "a mesh for a scene is read with --static NAME=FILE"
        ),
        r"Load it with Body\.load": "Give it with --body",
        r"(no known motion format\. Found (?s:.*?))\. Expected one of: .*": (
            r"\1. Expected a motion file; halfphysics formats lists those that are read"
        ),
        r"begins with b'((?:[^'\\]|\\.)*)'": r"begins with '\1'",
        r"Sequence\.body is None\b": "It has no body of its own",
        r"It has no body of its own, for": "the person has no body, for",
        # bodies
        r"Load the motion's model \(Body\.load\([^)]*\)\), use Body\.default\(\), or": (
            "Give the motion's model with --body, leave out --body for the default body, or"
        ),
        r"Body\.default\(stature=\.\.\.\) or \(bones=\.\.\.\) \[m\]; or load the motion's model "
        r"with Body\.load": "--stature gives the one; or give the motion's model with --body",
        r"give the path of a file or a folder, set": "give --body a file or a folder, set",
        r"or use Body\.default\(\)": "or leave out --body",
        r"Give a body of your own": "Give a body with --body",
        r", or pass (body|scene)= to Result\.load": r", or give evaluate one with --\1",
        # motions
        r"Use more substeps=": "Use more --substeps",
        r"motion\.grounded\(body, z=\.\.\.\), or --grounded": "--grounded",
        r"see motion\.grounded\(body\) for": "see --grounded for",
        r", or index with motion\[i\] for a Pose": "",
        r"Use motion\.resample\(fps\) and (slices motion\[a:b\]|motion\[:frames\])": (
            "Change them with halfphysics convert, --to-fps and --frames"
        ),
        r"cut the longer one \(motion\[:n\]\) or resample one \(motion\.resample\(fps\)\)": (
            "cut the longer one (halfphysics convert --frames) or resample one (--to-fps)"
        ),
        r"resample one: motion\.resample\(fps\)": "resample one: halfphysics convert --to-fps",
        r"create the smplx model with use_pca=False, or multiply": "multiply",
        # scenes
        r"add a single mesh with Scene\(\)\.add_static\(name, path\)": (
            "a single mesh is added with --static NAME=FILE"
        ),
        r"Add planes with add_static\(name, Plane\(\)\)": "Add planes as static items",
        r"add_object and add_static take what is rigid": "what is rigid is an object or static",
        r"add_static takes planes": "planes are static",
        r"with scene\.add_static": "with --static",
        r"; or give halfphysics\.Soft\(thickness, stiffness\)": (
            "; a scene file may give thickness and stiffness instead"
        ),
        r"expected halfphysics\.Soft\(thickness, stiffness\) or one of ": (
            "expected thickness and stiffness, or one of "
        ),
        r"expected [Tt]rue, [Ff]alse or a halfphysics\.body\.soft_skin\.SoftSkin": (
            "expected yes or no"
        ),
        r"say where with joints=(\{[^}]*\})": r"say where with joints: \1",
        r", give pieces=\[convex meshes\], or say pieces=\"hull\"": ", or say pieces=hull",
        r"cuts finer; pieces=\[convex meshes\] gives your own": "cuts finer",
        r"; pieces=\"auto\" cuts the mesh itself": "; pieces=auto cuts the mesh itself",
        r"start='asleep'": "start: asleep",
        r"or give mass= and com=": "or give mass and com",
        r"give mass= and com=": "give mass and com",
        r"Then say scale=([\d.e-]+)": (
            r"Then say so: --static NAME=FILE,scale=\1, or scale: \1 in the scene file"
        ),
        r"is ([yz]) up\? Then say up='[yz]' \(up='([yz])': it is right\)": (
            r"is \1 up? Then say so: --static NAME=FILE,up=\1, or up: \1 in the scene file (up \2: "
            "it is right)"
        ),
        # baselines
        r"^Torque(?=: )": "torque",
        r"^Positions(?=: )": "positions",
        r"^Interpolated(?=: )": "interpolated",
        r"^Kinematic(?=: )": "kinematic",
        r"\bEngineKinematic\b(?!\.)": "engine_kinematic",
        r"\bEngineVelocity\b(?!\.)": "engine_velocity",
        r"\bAblation\b(?!\.)": "velocity",
        r"say motion\.resample\((\S+?)\)": r"say to_fps=\1",
        r", or halfphysics\.Settings": ", or --mode velocity",
        r"; expected halfphysics\.Settings\b": "; expected --mode velocity",
        r"use halfphysics\.Settings": "use --mode velocity",
        r"from fields of halfphysics\.Settings": "from settings",
        r"halfphysics\.Settings has no such field": "there is no such setting",
        # results and writers
        r"\(Result\.save writes one\)": "(halfphysics simulate --out writes one)",
        r"\(Result\.save\)": "(halfphysics simulate --out writes one)",
        r"\. A motion file is read with Motion\.load": "",
        r"\. Motion\.load reads the motion on top": "",
        r"; leave more room, or see Result\.lost_time for the frames": "; leave more room",
        r"such as hp\.Result\.load\(path\)": "such as halfphysics simulate --out writes",
        r", or a Motion, such as hp\.Motion\.load\(path\)": ", or any motion file",
        r", by halfphysics\.export": "",
        r"Motions alone are written by Motion\.save": "halfphysics convert writes motions alone",
        r", or a name of halfphysics\.JOINT_NAMES": ", or the name of a joint, such as left_knee",
        r", see halfphysics\.JOINT_NAMES": ", such as left_knee",
        r"one of JOINT_NAMES": "the name of a joint, such as left_knee",
        r"(?:Posix|Windows)?Path\('([^']*)'\)": r"'\1'",
        r"\b[A-Z]\w*(?:Error|Exception): ": "",
    }
)

#: Names that are left, as nouns.
_WORDS = _compiled(
    {
        r"\bBody\.default\(\)": "the default body",
        r"\b(?:halfphysics|hp)\.(Body|Scene|Motion|Pose|Result|Sequence)\b": r"\1",
        r"\ba mujoco\.MjSpec": "a model of MuJoCo",
        r"trimesh\.Trimesh": "mesh",
        r"\bhalfphysics\.Settings\b": "settings",
        # a capital at the beginning of a sentence is no name, nor is SAM 3D Body or HY-Motion
        **{
            rf"(?<!\A)(?<!\. )(?<!3D )(?<![-\w]){name}\b(?!-)": name.lower()
            for name in (
                *("Body", "Scene", "Motion", "Pose", "Result", "Sequence", "Plane", "Box"),
                *("Sphere", "Capsule", "Cylinder", "Mesh"),
            )
        },
        r"\bNone\b": "none",
        r"\bTrue\b": "true",
        r"\bFalse\b": "false",
    }
)
