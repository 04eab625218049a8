"""Names of factors: the quantity that each varies, and its possible values.

settings.FIELD                 a field of halfphysics.Settings, or an option of a baseline
body.stature, body.betas.K     height of the default body [m]; its K-th shape number
motion.X                       speed, fps, offset_x, offset_y, offset_z [m], yaw [deg]
scenario.OPTION                an option of the scenarios
objects.X, object.NAME.X       of all objects, of one: mass [kg], mass_factor, friction,
                               restitution, scale, offset_x, offset_y, offset_z [m], yaw [deg]
statics.X, static.NAME.X       the same without mass and mass_factor
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import real, shown
from halfphysics.baselines.options import OPTIONS, from_options
from halfphysics.errors import InputError
from halfphysics.sweep.plan.values import Normal, Spec, Value

Group: TypeAlias = Literal[
    "settings", "body", "motion", "scenario", "objects", "object", "statics", "static"
]


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """The possible numbers: from `least` to `most`, above `above`."""

    least: float = -math.inf
    most: float = math.inf
    above: float = -math.inf

    def check(self, name: str, value: Value) -> None:
        """Raise `InputError` if the value is no number or out of bounds."""
        found = real(value, plain=True)
        if found is None or not (self.least <= found <= self.most and found > self.above):
            raise InputError(f"{name}: found {shown(value)}, expected {self}")

    def __str__(self) -> str:
        parts = []
        if self.above > -math.inf:
            parts.append(f"above {self.above:g}")
        if self.least > -math.inf:
            parts.append(f"of at least {self.least:g}")
        if self.most < math.inf:
            parts.append(f"of at most {self.most:g}")
        return " ".join(["a number", " and ".join(parts)]).strip()


_ANY, _POSITIVE = Bounds(), Bounds(above=0.0)
#: Factors that translate an object or motion, one per axis [m].
OFFSETS = ("offset_x", "offset_y", "offset_z")
_PLACE = {name: _ANY for name in (*OFFSETS, "yaw")}

MOTION: Mapping[str, Bounds] = {"speed": _POSITIVE, "fps": _POSITIVE, **_PLACE}
STATIC: Mapping[str, Bounds] = {
    "friction": Bounds(least=0.0),
    "restitution": Bounds(least=0.0, most=1.0),
    "scale": _POSITIVE,
    **_PLACE,
}
OBJECT: Mapping[str, Bounds] = {"mass": _POSITIVE, "mass_factor": _POSITIVE, **STATIC}
STATURE = Bounds(least=0.4, most=2.8)

#: Largest number of shape numbers of a body model.
_MOST_BETAS = 400
#: Options of a scenario that are no plain values; other factors vary these objects.
NOT_PLAIN = ("body", "other")

_GROUPS: Mapping[str, str] = {
    "settings": "settings.FIELD",
    "body": "body.stature, body.betas.K",
    "motion": f"motion.X with X one of {', '.join(MOTION)}",
    "scenario": "scenario.OPTION",
    "objects": f"objects.X with X one of {', '.join(OBJECT)}",
    "object": f"object.NAME.X with X one of {', '.join(OBJECT)}",
    "statics": f"statics.X with X one of {', '.join(STATIC)}",
    "static": f"static.NAME.X with X one of {', '.join(STATIC)}",
}


@dataclass(frozen=True, kw_only=True)
class FactorName:
    """The parts of a factor's name.

    Attributes:
        group: Its first word.
        item: NAME of object.NAME.X and static.NAME.X, "" for other factors.
        what: Its last word; K of body.betas.K with "betas." before it.
    """

    group: Group
    item: str
    what: str

    @classmethod
    def parse(cls, name: str) -> FactorName:
        """Split a name into its parts.

        Raises:
            InputError: No factor has this name.
        """
        if not isinstance(name, str):
            raise InputError(f"factors: found {shown(name)}, expected names such as objects.mass")
        group, _, rest = name.partition(".")
        if group not in _GROUPS or not rest:
            raise InputError(
                f"{name}: no factor is called that{_meant(group, _GROUPS)} Expected "
                + "; ".join(_GROUPS.values())
            )
        item, what = rest.rpartition(".")[::2] if group in ("object", "static") else ("", rest)
        if group in ("object", "static") and not item:
            raise InputError(f"{name}: expected {_GROUPS[group]}; {group}s.{rest} is of all")
        known = _WHATS.get(group)
        if group == "body":
            _check_body(name, what)
        elif known is not None and what not in known:
            raise InputError(
                f"{name}: found {what!r}{_meant(what, known)} Expected one of {', '.join(known)}"
            )
        return cls(group=group, item=item, what=what)  # type: ignore[arg-type]

    @property
    def bounds(self) -> Bounds | None:
        """The possible numbers; None if they depend on more than the name (settings, scenarios)."""
        if self.group == "body":
            return STATURE if self.what == "stature" else _ANY
        if self.group == "motion":
            return MOTION[self.what]
        if self.group in ("settings", "scenario"):
            return None
        return OBJECT[self.what]

    @property
    def beta(self) -> int | None:
        """K of body.betas.K."""
        return int(self.what.removeprefix("betas.")) if self.what.startswith("betas.") else None


_WHATS: Mapping[str, tuple[str, ...]] = {
    "settings": OPTIONS,
    "motion": tuple(MOTION),
    "objects": tuple(OBJECT),
    "object": tuple(OBJECT),
    "statics": tuple(STATIC),
    "static": tuple(STATIC),
}


def check_factors(
    factors: Mapping[str, Spec], settings: Mapping[str, Any], scenarios: Iterable[str], files: bool
) -> None:
    """Refuse factors without effect and impossible values.

    Args:
        factors: Name -> values.
        settings: The plan's settings, the same for all variants.
        scenarios: Names of the scenarios among the inputs.
        files: Whether some inputs are files.

    Raises:
        InputError: The message begins with the factor's name.
    """
    for name, values in factors.items():
        parsed = FactorName.parse(name)
        if parsed.bounds is not None:
            for value in values.extremes():
                _within(values, parsed.bounds.check, name, value)
        if parsed.group == "scenario":
            _check_option(name, parsed.what, tuple(scenarios), files)
        if parsed.group == "settings" and parsed.what in settings:
            raise InputError(f"{name}: {parsed.what} is also in settings; leave out one of the two")
        if parsed.what == "mass_factor" and (absolute := name.removesuffix("_factor")) in factors:
            raise InputError(f"{name}: found beside {absolute}; leave out one of the two")
    _check_settings(factors, settings)


def check_settings(settings: Mapping[str, Any]) -> None:
    """Refuse fields that `halfphysics.Settings` does not have, and impossible values.

    Raises:
        InputError: The message names the field.
    """
    for name in settings:
        if name not in OPTIONS:
            raise InputError(
                f"{name}: halfphysics.Settings has no such field{_meant(name, OPTIONS)} Expected "
                f"one of {', '.join(OPTIONS)}"
            )
    from_options(settings)


def _within(values: Spec, check: Callable[..., None], *args: Any) -> None:
    """check(*args); for a normal distribution without ends, the message advises `within`."""
    try:
        check(*args)
    except InputError as error:
        if isinstance(values, Normal) and values.within is None:
            raise InputError(f"{error}. Add within: [low, high] to the distribution") from None
        raise


def _check_body(name: str, what: str) -> None:
    beta = what.removeprefix("betas.")
    whole = beta.isascii() and beta.isdigit() and str(int(beta)) == beta
    if what != "stature" and not (what.startswith("betas.") and whole and int(beta) < _MOST_BETAS):
        raise InputError(
            f"{name}: found {what!r}{_meant(what, ('stature', 'betas.0'))} Expected stature, or "
            f"betas.K with a whole number K from 0 to {_MOST_BETAS - 1}"
        )


def _check_option(name: str, option: str, scenarios: tuple[str, ...], files: bool) -> None:
    from halfphysics import scenarios as built_in

    if files or not scenarios:
        raise InputError(
            f"{name}: is for plans whose inputs are all scenarios; this one has files. Make two "
            "plans"
        )
    for scenario in scenarios:
        known = tuple(o for o in built_in.options(scenario) if o not in NOT_PLAIN)
        if option not in known:
            raise InputError(
                f"{name}: the scenario {scenario} has no option {option!r}{_meant(option, known)} "
                f"Expected one of {', '.join(known)}"
            )


def _check_settings(factors: Mapping[str, Spec], settings: Mapping[str, Any]) -> None:
    """Check that each value of a setting is valid with some values of the others."""
    axes = {
        name.partition(".")[2]: values
        for name, values in factors.items()
        if name.startswith("settings.")
    }
    for field, values in axes.items():
        others = {other: axes[other].extremes() for other in axes if other != field}
        for value in values.extremes():
            name = f"settings.{field}"
            _within(values, _check_setting, {**settings, field: value}, others, name)


def _check_setting(
    chosen: Mapping[str, Any], others: Mapping[str, tuple[Value, ...]], name: str
) -> None:
    first = ""
    ways = itertools.product(*others.values())
    for way in ({}, *(dict(zip(others, w, strict=True)) for w in itertools.islice(ways, 1000))):
        try:
            from_options({**chosen, **way})
        except InputError as error:
            first = first or str(error)
        else:
            return
    raise InputError(f"{name}: {first}")


def _meant(word: str, known: Iterable[str]) -> str:
    return did_you_mean(word, known, otherwise=".")
