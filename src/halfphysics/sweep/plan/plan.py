"""The plan of a sweep: a frozen dataclass, from a file (docs/sweeps.md) or made in Python."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.expression import Expression
from halfphysics.sweep.plan.factors import check_factors, check_settings
from halfphysics.sweep.plan.inputs import Input, InputList, Inputs, resolve
from halfphysics.sweep.plan.outputs import Labels, Outputs
from halfphysics.sweep.plan.values import Axis, Drawn, Spec, spec

__all__ = [
    "BodyChoice",
    "Input",
    "InputList",
    "Inputs",
    "Labels",
    "Outputs",
    "Plan",
    "SceneChoice",
    "resolve_inputs",
]

#: Version written into files; a reader of another version raises an error with both numbers.
VERSION = 1

#: Names that expressions may use beside the factors.
OF_VARIANT = ("input", "body", "scene")
#: Further names that `keep_after` may use: the single values of the card about the result.
OF_RESULT = (
    "success",
    "frames",
    "fps",
    "seconds",
    "lost_time",
    "clearance_min",
    "started_inside",
    "joint_error_mean_mm",
    "joint_error_max_mm",
    "pose_error_mean_mm",
    "contacts",
    "threshold_m",
    "impulse",
    "force_max",
    "holds",
    "held_seconds",
    "lost_grasps",
    "slips",
    "slid",
    "drops",
    "travel_max",
    "pressure_max",
    "pressure_mean",
    "pressure_area",
)
#: Those of them about soft things, 0 where nothing is.
OF_SOFT = ("pressure_max", "pressure_mean", "pressure_area")
#: Further names that `keep_after` may use with `Outputs.support`.
OF_SUPPORT = ("unsupported_percent", "carried_max")

_MOST_SEED = 2**63 - 1


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A sweep: inputs x bodies x scenes x values of factors, and which variants are kept.

    Attributes:
        inputs: Entries of files or scenarios.
        bodies: The axis of bodies.
        scenes: The axis of scenes.
        grounded: Move each motion up or down until its lowest point is on z = 0.
        factors: Name (see `sweep.factors`) -> values: a list, a range or a distribution (see
            `sweep.values`; plain data is taken as in a file).
        samples: Draws of the distributions for each combination of the other axes.
        seed: Seed of the draws.
        keep: Expressions (see `sweep.expression`) that hold for the variants to simulate.
        keep_after: Expressions, also on values of the card, that hold for the samples to keep.
        settings: Fields of `halfphysics.Settings`, the same for all variants.
        labels: How contact is labelled.
        outputs: Where results go.
        base: The folder that paths and patterns are relative to; no part of the identity.
    """

    inputs: tuple[Inputs, ...]
    bodies: tuple[BodyChoice, ...] = (BodyChoice(),)
    scenes: tuple[SceneChoice, ...] = (SceneChoice(),)
    grounded: bool = False
    factors: Mapping[str, Spec] = field(default_factory=dict)
    samples: int = 1
    seed: int = 0
    keep: tuple[str, ...] = ()
    keep_after: tuple[str, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    labels: Labels = field(default_factory=Labels)
    outputs: Outputs = field(default_factory=Outputs)
    base: Path = field(default=Path(), compare=False)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "inputs", _several(self.inputs, Inputs, "inputs"))
        set_(self, "bodies", _several(self.bodies, BodyChoice, "bodies"))
        set_(self, "scenes", _several(self.scenes, SceneChoice, "scenes"))
        for axis in (self.bodies, self.scenes):
            names = [choice.name for choice in axis]
            for k, name in enumerate(names):
                if name in names[:k]:
                    what = "bodies" if axis is self.bodies else "scenes"
                    raise InputError(f"{what}: found {name} twice, expected each once")
        for name, kind in (("labels", Labels), ("outputs", Outputs)):
            if not isinstance(getattr(self, name), kind):
                raise InputError(f"{name}: found {shown(getattr(self, name))}, expected {kind}")
        if not isinstance(self.grounded, bool):
            raise InputError(f"grounded: found {shown(self.grounded)}, expected true or false")
        _whole(self.seed, "seed", 0)
        _whole(self.samples, "samples", 1)
        for name in ("factors", "settings"):
            if not isinstance(getattr(self, name), Mapping):
                raise InputError(f"{name}: found {shown(getattr(self, name))}, expected a mapping")
        self._check_scenes()
        set_(self, "settings", dict(self.settings))
        check_settings(self.settings)
        set_(self, "factors", _specs(self.factors))
        self._check_factors()
        for name in ("keep", "keep_after"):
            set_(self, name, _expressions(getattr(self, name), name))
            self.expressions(name)
        set_(self, "base", Path(self.base))

    def _check_scenes(self) -> None:
        """A scenario has its own scene; with another scene all its variants would fail."""
        others = [scene.name for scene in self.scenes if scene.file is not None]
        names = [name for given in self.inputs for name in given.scenarios]
        if others and names:
            raise InputError(
                f"scenes: found {others[0]} with the scenario {names[0]}, which brings a scene of "
                "its own; expected own. Sweep motion files through it in a plan of their own"
            )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Plan:
        """The plan in a .yaml, .yml or .json file.

        Raises:
            FileError: The file does not exist or has a mistake; the message gives the place.
        """
        from halfphysics.sweep.plan.plan_file import load_plan

        return load_plan(path)

    @classmethod
    def from_document(cls, document: Mapping[str, Any], base: Path) -> Plan:
        """The plan of plain data in the file's format.

        Args:
            document: Plain data as returned by `document`; keys may be left out.
            base: The folder that its paths are relative to.

        Raises:
            FileError: The document has a mistake; the message gives the place.
        """
        from halfphysics.sweep.plan.plan_file import plan_of

        return plan_of(document, base)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the plan as YAML; paths stay unchanged, relative to `base`.

        Raises:
            FileError: The file cannot be written.
        """
        from halfphysics.sweep.plan.plan_file import save_plan

        save_plan(self, path)

    def document(self) -> dict[str, Any]:
        """The plan as plain data in the file's format, defaults written out, `base` left out."""
        return {
            "version": VERSION,
            "inputs": [entry.document() for entry in self.inputs],
            "bodies": [body.document() for body in self.bodies],
            "scenes": [scene.document() for scene in self.scenes],
            "grounded": self.grounded,
            "factors": {name: values.document() for name, values in self.factors.items()},
            "samples": self.samples,
            "seed": self.seed,
            "keep": list(self.keep),
            "keep_after": list(self.keep_after),
            "settings": {k: _plain(v) for k, v in sorted(self.settings.items())},
            "labels": self.labels.document(),
            "outputs": self.outputs.document(),
        }

    @property
    def identity(self) -> str:
        """SHA-256 (hex) of the document without outputs.folder.

        The output bytes depend on this, on the input files (here only patterns) and on the program.
        """
        document = self.document()
        del document["outputs"]["folder"]
        # Factors keep their order: it is the order of the axes.
        text = json.dumps(document, ensure_ascii=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def folder(self) -> Path:
        """The output folder, as a path that can be opened."""
        return self.base / self.outputs.folder

    @property
    def axes(self) -> dict[str, Axis]:
        """The factors whose values are all combined, in order."""
        return {k: v for k, v in self.factors.items() if isinstance(v, Axis)}

    @property
    def drawn(self) -> dict[str, Drawn]:
        """The factors whose values are drawn."""
        return {k: v for k, v in self.factors.items() if isinstance(v, Drawn)}

    def expressions(self, which: str) -> tuple[Expression, ...]:
        """The expressions of "keep" or "keep_after", ready to evaluate.

        Raises:
            InputError: An expression is invalid or has an unknown name.
        """
        known = (*OF_VARIANT, *self.factors, *(OF_RESULT if which == "keep_after" else ()))
        if which == "keep_after" and self.outputs.support:
            known = (*known, *OF_SUPPORT)
        texts: tuple[str, ...] = getattr(self, which)
        made = []
        for k, text in enumerate(texts):
            try:
                made.append(Expression(text, known))
            except InputError as error:
                where = f"{which}[{k}]" if len(texts) > 1 else which
                more = "" if self.outputs.support else _needs_support(which, text)
                raise InputError(f"{where}: {error}{more}") from None
        return tuple(made)

    def _check_factors(self) -> None:
        scenarios = [name for entry in self.inputs for name in entry.scenarios]
        files = any(entry.files for entry in self.inputs)
        check_factors(self.factors, self.settings, scenarios, files)
        for entry in self.inputs:
            for option in entry.options if entry.scenarios else ():
                if f"scenario.{option}" in self.factors:
                    raise InputError(
                        f"scenario.{option}: {option} is also said at the inputs; leave out one of "
                        "the two"
                    )
        if "body.stature" in self.factors:
            for body in self.bodies:
                if body.model is not None or body.stature is not None:
                    raise InputError(
                        f"body.stature: found beside the body {body.name}; stature is for the "
                        "default body, and said once. Leave out one of the two"
                    )
        if self.samples > 1 and not self.drawn:
            raise InputError(
                f"samples: found {self.samples} without a distribution among the factors; all "
                "samples would be the same. Leave it out, or draw a factor"
            )


def resolve_inputs(plan: Plan, folder: str | os.PathLike[str] | None = None) -> list[str]:
    """The plan's inputs, one line each ("file" or "scenario", name, number of the entry; tabs).

    Args:
        plan: The plan; what is in its output folder is no input.
        folder: The folder that is written to instead, relative to the working directory; what is
            in it is no input either.

    Raises:
        FileError: No file matches a pattern.
    """
    others = () if folder is None else (os.path.abspath(folder),)
    return resolve(plan.inputs, plan.base, plan.outputs.folder, *others)


def _needs_support(which: str, text: str) -> str:
    """What to add to the message about an expression with a name of `OF_SUPPORT`."""
    names = [name for name in OF_SUPPORT if name in text]
    if which != "keep_after" or not names:
        return ""
    return f". {names[0]} needs outputs: {{support: true}}"


def _specs(factors: Mapping[str, Any]) -> dict[str, Spec]:
    made = {}
    for name, value in factors.items():
        try:
            made[name] = spec(value)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
    return made


def _expressions(value: Any, what: str) -> tuple[str, ...]:
    texts = (value,) if isinstance(value, str) else value
    if not isinstance(texts, list | tuple) or not all(isinstance(t, str) for t in texts):
        raise InputError(f"{what}: found {shown(value)}, expected an expression or a list of them")
    return tuple(texts)


def _several(value: Any, kind: type[Any], what: str) -> tuple[Any, ...]:
    several = (value,) if isinstance(value, kind) else value
    if not isinstance(several, list | tuple) or not several:
        raise InputError(f"{what}: found {shown(value)}, expected one {kind.__name__} or more")
    for one in several:
        if not isinstance(one, kind):
            raise InputError(f"{what}: found {shown(one)}, expected {kind.__name__}")
    return tuple(several)


def _whole(value: Any, what: str, least: int) -> None:
    if not is_whole(value, least=least) or value > _MOST_SEED:
        raise InputError(
            f"{what}: found {shown(value)}, expected a whole number of at least {least}"
        )


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else value
