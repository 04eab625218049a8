"""What the playground can play: built-in scenarios, files, and one's motion in another's scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from halfphysics import scenarios
from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.simulation.sequence import Sequence

#: The motion that a scenario brings along.
OWN = "its own"

# Options of scenarios that have a slider of their own in the playground, or none.
_ELSEWHERE = ("fps", "mass", "friction", "body", "other")


@dataclass(frozen=True)
class Option:
    """A number that a scenario is built with.

    Attributes:
        name: As `scenarios.load` has it.
        low, high, step: Of a slider.
        value: What the scenario takes where nothing is said.
    """

    name: str
    low: float
    high: float
    step: float
    value: float


# Where 0 to twice the default is not what a slider should offer: (low, high, value).
_RANGES: Mapping[tuple[str, str], tuple[float, float, float]] = MappingProxyType(
    {
        ("close_drawer", "travel"): (0.05, 0.3, 0.28),
        ("doorway", "right_jamb"): (-0.6, 0.0, -0.235),
        ("kick_ball", "radius"): (0.04, 0.3, 0.11),
        ("kick_ball", "speed"): (0.5, 15.0, 5.5),
        ("lift_suitcase", "carry"): (1.0, 10.0, 5.0),
        ("meet", "offset"): (-1.0, 1.0, 0.0),
        ("meet", "speed"): (0.2, 2.2, 1.5),
        ("meet", "stature"): (1.2, 2.0, 1.6),
        ("push_door", "speed"): (0.2, 2.2, 1.0),
        ("shake_hands", "stature"): (1.5, 1.9, 1.6),
        ("walk_into_wall", "speed"): (0.2, 2.2, 1.5),
        ("walk_into_wall", "thickness"): (0.005, 0.1, 0.01),
    }
)


def options(scenario: str) -> tuple[Option, ...]:
    """What a built-in scenario can be built with besides mass and friction; a file has none."""
    if scenario not in scenarios.names():
        return ()
    found = []
    for name, default in scenarios.options(scenario).items():
        if name in _ELSEWHERE or isinstance(default, bool | str | tuple):
            continue
        if (scenario, name) in _RANGES:
            low, high, value = _RANGES[scenario, name]
        else:
            low, high, value = 0.0, 2.0 * default, default
        whole = isinstance(default, int)
        step = 1 if whole else 10.0 ** -_decimals(high - low)
        kind = int if whole else float
        found.append(Option(name, kind(low), kind(high), step, kind(value)))
    return tuple(found)


def _decimals(span: float) -> int:
    """Decimals of a slider with at least a hundred steps, three at most."""
    return next((n for n in range(3) if span * 10**n >= 100.0), 3)


@dataclass(frozen=True)
class Choice:
    """What is played.

    Attributes:
        scenario: Where: a built-in scenario or a file with what was recorded around it.
        motion: What the person does: another scenario or file, or `OWN`.
        options: Numbers that the scenario is built with.
    """

    scenario: str
    motion: str = OWN
    options: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.scenario if self.motion == OWN else f"{self.motion} in {self.scenario}"


class Catalog:
    """All that can be chosen.

    Args:
        files: Name -> what loads it.
    """

    def __init__(self, files: Mapping[str, Callable[[], Sequence]] | None = None) -> None:
        self._files = dict(files or {})
        self._loaded: dict[str, Sequence] = {}
        #: Names of scenarios, files first.
        self.scenarios: tuple[str, ...] = (*self._files, *scenarios.names())
        #: Names of motions, `OWN` first.
        self.motions: tuple[str, ...] = (OWN, *self.scenarios)

    def load(self, choice: Choice) -> Sequence:
        """What to simulate.

        Raises:
            InputError: An unknown name, or an impossible option.
            FileError: A file that cannot be used.
        """
        place = self._sequence(choice.scenario, choice.options)
        if choice.motion == OWN:
            return place
        actor = self._sequence(choice.motion, {})
        return Sequence(actor.motion, place.scene, actor.body, place.settings)

    def _sequence(self, name: str, chosen: Mapping[str, float]) -> Sequence:
        if name in self._files:
            if name not in self._loaded:
                self._loaded[name] = self._files[name]()
            return self._loaded[name]
        if name not in self.scenarios:
            raise InputError(f"play: found {name!r}, expected one of {', '.join(self.scenarios)}")
        known = {option.name for option in options(name)}
        for option, value in chosen.items():
            if option in known:  # `scenarios.load` tells of those that it does not know
                number(value, f"{name}: {option}")
        return scenarios.load(name, **chosen)
