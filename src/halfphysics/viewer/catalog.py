"""The playground's choices: scenarios, files, and the motion of one in the scene of another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from halfphysics import scenarios
from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.simulation.sequence import Sequence

#: The scenario's own motion.
OWN = "its own"

# Options of scenarios with another slider in the playground, or with none.
_ELSEWHERE = ("fps", "mass", "friction", "body", "other")


@dataclass(frozen=True)
class Option:
    """A numeric option of a scenario.

    Attributes:
        name: Name of the option in `scenarios.load`.
        low, high, step: Range and step of the slider.
        value: The default.
    """

    name: str
    low: float
    high: float
    step: float
    value: float


# Ranges of sliders other than 0 to twice the default: (low, high, value).
_RANGES: Mapping[tuple[str, str], tuple[float, float, float]] = MappingProxyType(
    {
        ("ball_on_cushion", "height"): (0.75, 1.2, 1.0),
        ("ball_on_cushion", "radius"): (0.05, 0.15, 0.11),
        ("climb_onto_bed", "sink"): (0.04, 0.12, 0.05),
        ("close_drawer", "travel"): (0.05, 0.3, 0.28),
        ("crawl_under_table", "hunch"): (0.0, 0.075, 0.07),
        ("doorway", "right_jamb"): (-0.6, 0.0, -0.235),
        ("jump_on_bed", "height"): (0.02, 0.4, 0.15),
        ("jump_on_bed", "jumps"): (1, 5, 2),
        ("kick_ball", "radius"): (0.04, 0.3, 0.11),
        ("kick_ball", "speed"): (0.5, 15.0, 5.5),
        ("lift_suitcase", "carry"): (1.0, 10.0, 5.0),
        ("meet", "offset"): (-1.0, 1.0, 0.0),
        ("meet", "speed"): (0.2, 2.2, 1.5),
        ("meet", "stature"): (1.2, 2.0, 1.6),
        ("push_door", "speed"): (0.2, 2.2, 1.0),
        ("shake_hands", "stature"): (1.5, 1.9, 1.6),
        ("sit_on_bed", "sink"): (0.0, 0.1, 0.07),
        ("sit_on_sofa", "sink"): (0.0, 0.15, 0.08),
        ("squeeze_pillow", "carry"): (1.0, 10.0, 1.5),
        ("walk_into_wall", "speed"): (0.2, 2.2, 1.5),
        ("walk_into_wall", "thickness"): (0.005, 0.1, 0.01),
    }
)


def options(scenario: str) -> tuple[Option, ...]:
    """Options of a built-in scenario that are numbers, but mass and friction; none of a file."""
    if scenario not in scenarios.names():
        return ()
    found = []
    for name, default in scenarios.options(scenario).items():
        number = isinstance(default, int | float) and not isinstance(default, bool)
        if name in _ELSEWHERE or not number:
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
    """Decimals of a slider with at least 100 steps, three at most."""
    return next((n for n in range(3) if span * 10**n >= 100.0), 3)


@dataclass(frozen=True)
class Choice:
    """A choice of scenario and motion.

    Attributes:
        scenario: The source of the scene: a built-in scenario or a file.
        motion: The source of the motion: another scenario or file, or `OWN`.
        options: Values of the scenario's numeric options.
    """

    scenario: str
    motion: str = OWN
    options: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.scenario if self.motion == OWN else f"{self.motion} in {self.scenario}"


class Catalog:
    """The available scenarios and motions.

    Args:
        files: Name -> function that loads the file.
    """

    def __init__(self, files: Mapping[str, Callable[[], Sequence]] | None = None) -> None:
        self._files = dict(files or {})
        self._loaded: dict[str, Sequence] = {}
        #: Names of scenarios, files first.
        self.scenarios: tuple[str, ...] = (*self._files, *scenarios.names())
        #: Names of motions, `OWN` first.
        self.motions: tuple[str, ...] = (OWN, *self.scenarios)

    def load(self, choice: Choice) -> Sequence:
        """The sequence to simulate for a choice.

        Raises:
            InputError: An unknown name, or an invalid option.
            FileError: A file cannot be used.
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
            if option in known:  # `scenarios.load` refuses unknown options
                number(value, f"{name}: {option}")
        return scenarios.load(name, **chosen)
