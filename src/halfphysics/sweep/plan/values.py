"""The values of a factor: a list, a range or a distribution."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Literal, TypeAlias

from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.sweep.plan.draws import Stream, exp, log

#: A value of a factor.
Value: TypeAlias = float | int | str | bool | None

#: Share of a normal distribution that must lie in `within`: draws outside are drawn again.
_LEAST_SHARE = 0.01
#: Number of standard deviations that contain practically all draws of a normal distribution.
_FAR = 6
_MOST_VALUES = 1_000_000
#: Largest ratio of two numbers whose logarithms are divided: an exponential is exact within it.
_WIDEST = 1e300


@dataclass(frozen=True, kw_only=True)
class Listed:
    """A list of values; each is combined with the values of all other axes."""

    values: tuple[Value, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", _values(self.values, "values"))

    def listed(self) -> tuple[Value, ...]:
        """The values."""
        return self.values

    def extremes(self) -> tuple[Value, ...]:
        """The values to check: all values of the factor are possible if these are."""
        return self.values

    def document(self) -> Any:
        """The values as plain data."""
        return list(self.values)


@dataclass(frozen=True, kw_only=True)
class Range:
    """Numbers from `first` to `last`, both included, in even steps or by even factors ("log")."""

    first: float
    last: float
    count: int
    scale: Literal["linear", "log"] = "linear"

    def __post_init__(self) -> None:
        _number(self.first, "from")
        _number(self.last, "to")
        if not is_whole(self.count, least=2) or self.count > _MOST_VALUES:
            raise InputError(
                f"count: found {shown(self.count)}, expected a whole number of at least 2"
            )
        if self.scale not in ("linear", "log"):
            raise InputError(f"scale: found {shown(self.scale)}, expected linear or log")
        if self.scale == "log" and (self.first <= 0.0 or self.last <= 0.0):
            raise InputError(
                f"scale: found log for {self.first:g} to {self.last:g}; expected two numbers above "
                "0, or scale: linear"
            )
        _check_span(self.first, self.last, "to", self.scale == "log", self.count - 1)
        if self.first == self.last:
            raise InputError(
                f"to: found {self.last:g}, where it begins; expected another end, or a list of one"
            )
        if len(set(self.listed())) < self.count:
            raise InputError(
                f"count: found {self.count}, more numbers than there are from {self.first!r} to "
                f"{self.last!r}"
            )

    def listed(self) -> tuple[Value, ...]:
        """The numbers; integers if both ends and all steps are integers."""
        steps = self.count - 1
        span = self.last - self.first
        if self.scale == "log":
            rise = log(self.last / self.first) / steps
            inner = [self.first * exp(rise * k) for k in range(1, steps)]
        elif isinstance(span, int) and span % steps == 0:
            inner = [self.first + span // steps * k for k in range(1, steps)]
        else:
            inner = [self.first + span * k / steps for k in range(1, steps)]
        return (self.first, *inner, self.last)

    def extremes(self) -> tuple[Value, ...]:
        """The values to check: all values of the factor are possible if these are."""
        return self.listed()

    def document(self) -> Any:
        """The values as plain data."""
        return {"from": self.first, "to": self.last, "count": self.count, "scale": self.scale}


@dataclass(frozen=True, kw_only=True)
class Uniform:
    """Every number from `low` to `high` equally likely."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _interval(self.low, self.high, "uniform")
        _check_span(self.low, self.high, "uniform")

    def draw(self, stream: Stream, number: int) -> Value:
        """The number-th draw."""
        return self.low + (self.high - self.low) * stream.uniform(number)

    def extremes(self) -> tuple[Value, ...]:
        """The values to check (both ends), as floats: no integer will be drawn."""
        return (float(self.low), float(self.high))

    def document(self) -> Any:
        """The values as plain data."""
        return {"uniform": [self.low, self.high]}


@dataclass(frozen=True, kw_only=True)
class LogUniform:
    """Numbers from `low` to `high` whose logarithm is uniform: 1 to 2 as likely as 2 to 4."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _interval(self.low, self.high, "log_uniform")
        if self.low <= 0.0:
            raise InputError(f"log_uniform: found {self.low:g}, expected numbers above 0")
        _check_span(self.low, self.high, "log_uniform", log=True)
        object.__setattr__(self, "_span", log(self.high / self.low))

    def draw(self, stream: Stream, number: int) -> Value:
        """The number-th draw."""
        span: float = self._span  # type: ignore[attr-defined]
        return min(max(self.low * exp(span * stream.uniform(number)), self.low), self.high)

    def extremes(self) -> tuple[Value, ...]:
        """The values to check (both ends), as floats: no integer will be drawn."""
        return (float(self.low), float(self.high))

    def document(self) -> Any:
        """The values as plain data."""
        return {"log_uniform": [self.low, self.high]}


@dataclass(frozen=True, kw_only=True)
class Normal:
    """A normal distribution; with `within` (low, high), values outside are drawn again."""

    mean: float
    sd: float
    within: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        _number(self.mean, "normal: mean")
        if _number(self.sd, "normal: standard deviation") <= 0.0:
            raise InputError(
                f"normal: found standard deviation {self.sd:g}, expected one above 0: normal: "
                "[mean, standard deviation]"
            )
        if self.within is None:
            return
        low, high = _pair(self.within, "within")
        object.__setattr__(self, "within", (low, high))
        _interval(low, high, "within")
        a, b = ((end - self.mean) / (self.sd * math.sqrt(2.0)) for end in (low, high))
        share = (math.erf(b) - math.erf(a)) / 2.0
        if share < _LEAST_SHARE:
            raise InputError(
                f"within: found [{low:g}, {high:g}], where {100 * share:.2g} % of the distribution "
                f"lie; expected at least {100 * _LEAST_SHARE:g} %. Move the mean, or take uniform"
            )

    def draw(self, stream: Stream, number: int) -> Value:
        """The number-th draw."""
        draws = stream.normals(number)
        value = self.mean + self.sd * next(draws)
        if self.within is not None:
            low, high = self.within
            while not low <= value <= high:
                value = self.mean + self.sd * next(draws)
        return value

    def extremes(self) -> tuple[Value, ...]:
        """The values to check: both ends, without `within` those of two draws in a billion."""
        if self.within is not None:
            return (float(self.within[0]), float(self.within[1]))
        return tuple(float(self.mean + k * self.sd) for k in (-_FAR, _FAR))

    def document(self) -> Any:
        """The values as plain data."""
        inside = {} if self.within is None else {"within": list(self.within)}
        return {"normal": [self.mean, self.sd], **inside}


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A draw among values: equally likely, or in proportion to their weights."""

    values: tuple[Value, ...]
    weights: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", _values(self.values, "choice"))
        weights = (1.0,) * len(self.values)
        if self.weights is not None:
            if not isinstance(self.weights, list | tuple) or len(self.weights) != len(self.values):
                raise InputError(
                    f"weights: found {shown(self.weights)}, expected one number for each of the "
                    f"{len(self.values)} values of choice"
                )
            weights = tuple(number(w, "weights", above=0.0) for w in self.weights)
            object.__setattr__(self, "weights", tuple(self.weights))
        object.__setattr__(self, "_sums", tuple(accumulate(weights)))

    def draw(self, stream: Stream, number: int) -> Value:
        """The number-th draw."""
        sums: tuple[float, ...] = self._sums  # type: ignore[attr-defined]
        place = bisect_right(sums, sums[-1] * stream.uniform(number))
        return self.values[min(place, len(sums) - 1)]

    def extremes(self) -> tuple[Value, ...]:
        """The values to check: all values of the factor are possible if these are."""
        return self.values

    def document(self) -> Any:
        """The values as plain data."""
        weights = {} if self.weights is None else {"weights": list(self.weights)}
        return {"choice": list(self.values), **weights}


#: Kinds of values that form axes of the sweep, and kinds that are drawn for each variant.
Axis: TypeAlias = Listed | Range
Drawn: TypeAlias = Uniform | LogUniform | Normal | Choice
Spec: TypeAlias = Axis | Drawn

#: First key of a mapping -> all its keys.
FORMS: Mapping[str, tuple[str, ...]] = {
    "from": ("from", "to", "count", "scale"),
    "uniform": ("uniform",),
    "log_uniform": ("log_uniform",),
    "normal": ("normal", "within"),
    "choice": ("choice", "weights"),
}
EXPECTED = (
    "expected a value, a list of values, a range {from, to, count, scale}, or a distribution "
    "{uniform: [low, high]}, {log_uniform: [low, high]}, "
    "{normal: [mean, sd], within: [low, high]}, {choice: [...], weights: [...]}"
)


def spec(value: Any) -> Spec:
    """The values of a factor from plain data of a sweep file; a `Spec` is returned unchanged.

    Raises:
        InputError: The data is anything else; the message begins with the wrong key, if any.
    """
    if isinstance(value, Spec):
        return value
    if isinstance(value, list | tuple):
        return Listed(values=tuple(value))
    if not isinstance(value, Mapping):
        return Listed(values=(value,))
    form = next((key for key in FORMS if key in value), None)
    if form is None or not set(value) <= set(FORMS[form]):
        raise InputError(f"found a mapping with {', '.join(map(str, value))}; {EXPECTED}")
    given = dict(value)
    if form == "from":
        missing = [key for key in ("to", "count") if key not in given]
        if missing:
            raise InputError(f"found a range without {' and '.join(missing)}; {EXPECTED}")
        return Range(first=given.pop("from"), last=given.pop("to"), **given)
    if form == "choice":
        return Choice(values=given.pop("choice"), **given)
    first, second = _pair(given.pop(form), form)
    if form == "normal":
        return Normal(mean=first, sd=second, **given)
    return (Uniform if form == "uniform" else LogUniform)(low=first, high=second)


def _number(value: Any, what: str) -> float:
    return number(value, what)


def _pair(value: Any, what: str) -> tuple[float, float]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError(f"{what}: found {shown(value)}, expected a list of two numbers")
    for item in value:
        _number(item, what)
    return value[0], value[1]


def _interval(low: float, high: float, what: str) -> None:
    _number(low, what)
    if not low < _number(high, what):
        raise InputError(f"{what}: found [{low:g}, {high:g}], expected the smaller number first")


def _check_span(one: float, other: float, what: str, log: bool = False, steps: int = 1) -> None:
    """Check that the numbers between two others, above 0 if `log`, can be computed."""
    low, high = sorted((float(one), float(other)))
    if log and high / low > _WIDEST:
        raise InputError(
            f"{what}: found {one:g} to {other:g}, expected at most {_WIDEST:g} times the smaller "
            "number"
        )
    if not log and not math.isfinite((high - low) * steps):
        raise InputError(
            f"{what}: found {one:g} to {other:g}, expected numbers less far apart: their distance "
            "is too large for a number"
        )


def _values(values: Any, what: str) -> tuple[Value, ...]:
    """The values as a tuple, checked to be distinct."""
    if not isinstance(values, list | tuple) or not values:
        raise InputError(f"{what}: found {shown(values)}, expected a list of one value or more")
    seen = set()
    for value in values:
        if not isinstance(value, Value):
            raise InputError(
                f"{what}: found {shown(value)}, expected a number, text, true, false or null"
            )
        if isinstance(value, int | float) and not isinstance(value, bool):
            _number(value, what)
        key = _told_apart(value)
        if key in seen:
            raise InputError(f"{what}: found {shown(value)} twice, expected each value once")
        seen.add(key)
    return tuple(values)


def _told_apart(value: Value) -> tuple[str, Value]:
    """A key that is equal for values that give the same simulation."""
    if isinstance(value, bool) or value is None:
        return "word", value
    return ("text", value) if isinstance(value, str) else ("number", float(value))
