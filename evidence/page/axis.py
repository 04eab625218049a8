"""Axes of plots: the range of what is shown, ticks at round numbers, linear or in decades."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from typing import Any

from evidence.page.wording import signed

#: Positive values over as many decades are shown on a logarithmic axis.
_DECADES = 3
#: What is as many decades below everything else is rounding: as good as zero.
_ROUNDING = 6
#: A tick beyond the values is near within this share of their span.
_NEAR = 0.04
_LARGEST = sys.float_info.max
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Tick:
    """A round number: where it stands along the axis, from 0 to 1, and how it is written."""

    at: float
    label: str


@dataclass(frozen=True)
class Axis:
    """From `low` to `high`; both are powers of ten (the exponents) where `log`.

    `zero` says that a logarithmic axis has its lowest tick for what is not positive enough.
    """

    low: float
    high: float
    log: bool
    ticks: tuple[Tick, ...]
    zero: bool = False

    def at(self, value: float) -> float:
        """Where a value stands along the axis: 0 at its start, 1 at its end."""
        if self.log:
            if value <= 0:
                return 0.0
            return max(0.0, (math.log10(value) - self.low) / (self.high - self.low))
        # Halves, because a difference of two huge numbers may be none.
        return (value / 2 - self.low / 2) / (self.high / 2 - self.low / 2)


def finite(value: Any) -> float | None:
    """A number that can be drawn, or None (also for texts and truth values)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:  # an integer of more than 308 digits
        return None
    return number if math.isfinite(number) else None


def axis(
    values: Iterable[Any],
    *,
    ticks: int = 5,
    snug: bool = False,
    from_zero: bool = False,
    log: bool | None = None,
    decades: int = 300,
) -> Axis:
    """The axis that shows all values.

    Args:
        values: What is to be shown; what is no finite number is passed over.
        ticks: About how many ticks there is room for.
        snug: The axis ends at the outermost values, unless the ticks beyond them are near.
        from_zero: Zero is on a linear axis.
        log: Whether in decades; None: where no value is negative, and the positive ones span
            three decades and spread over decades at least as evenly as over the values
            themselves, without a gap of six decades. Negative values make it linear in any case.
        decades: A logarithmic axis shows as many at most, the uppermost ones; what is below
            stands with the zeros at its foot.
    """
    numbers = [x for x in map(finite, values) if x is not None]
    positive = sorted(x for x in numbers if x > 0)
    if log is None:
        log = _in_decades(positive)
    if log and positive and min(numbers) >= 0:
        return _logarithmic(positive, min(numbers) == 0, ticks, decades)
    return _linear(numbers or [0.0, 1.0], ticks, snug, from_zero)


def _in_decades(positive: list[float]) -> bool:
    """Whether sorted positive values are better told apart on a logarithmic axis."""
    if not positive or math.log10(positive[-1]) - math.log10(positive[0]) < _DECADES:
        return False
    powers = [math.log10(x) for x in positive]
    if any(b - a > _ROUNDING for a, b in pairwise(powers)):
        return False
    # How far from its middle an axis would have the median.
    off = [
        abs((some[len(some) // 2] + some[(len(some) - 1) // 2] - some[0] - some[-1]) / span)
        for some, span in (
            ([x / positive[-1] for x in positive], 1.0),
            (powers, powers[-1] - powers[0]),
        )
    ]
    return off[1] <= off[0]


def _logarithmic(positive: list[float], zeros: bool, ticks: int, decades: int) -> Axis:
    top = math.ceil(round(math.log10(max(positive)), 9))
    bottom = math.floor(round(math.log10(min(positive)), 9))
    if bottom == top:
        bottom -= 1
    if top - bottom > decades:
        bottom, zeros = top - decades, True
    step = max(1, math.ceil((top - bottom) / max(1, ticks)))
    marks = list(range(top, bottom - 1, -step))[::-1]
    low = marks[0] - step if zeros else bottom
    placed = [Tick((e - low) / (top - low), _power(e)) for e in marks]
    if zeros:
        placed.insert(0, Tick(0.0, "0"))
    return Axis(low, top, True, tuple(placed), zeros)


def _power(exponent: int) -> str:
    if -3 <= exponent <= 4:
        return _written(Decimal(1).scaleb(exponent), max(0, -exponent), False)
    return "10" + str(exponent).translate(_SUPERSCRIPT)


def _linear(numbers: list[float], ticks: int, snug: bool, from_zero: bool) -> Axis:
    low, high = min(numbers), max(numbers)
    if from_zero or (not snug and 0 <= low <= high / 2):
        low, high = min(low, 0.0), max(high, 0.0)
    size = max(abs(low), abs(high))
    if high / 2 - low / 2 <= max(size * 1e-9, 1e-290):  # one value, to what can be written
        if snug or size < 1e-280:
            room = size / 2 if size > 1e-280 else 0.5
            low, high = max(low - room, -_LARGEST), min(high + room, _LARGEST)
            snug = False
        else:
            low, high = min(low, 0.0), max(high, 0.0)
    mantissa, exponent = _step(high / ticks - low / ticks)
    step = float(Decimal(mantissa).scaleb(exponent))
    first, last = low / step, high / step
    if snug:
        near = _NEAR * (last - first)
        first = math.floor(first) if first - math.floor(first) <= near else first
        last = math.ceil(last) if math.ceil(last) - last <= near else last
        low = max(min(low, first * step), -_LARGEST)
        high = min(max(high, last * step), _LARGEST)
        counts = range(math.ceil(first - 1e-9), math.floor(last + 1e-9) + 1)
    else:
        counts = range(math.floor(first + 1e-9), math.ceil(last - 1e-9) + 1)
    values = [Decimal(k * mantissa).scaleb(exponent) for k in counts]
    # A tick beyond the largest number there is has no place.
    values = [v for v in values if math.isfinite(float(v))]
    if not snug:
        low, high = min(low, float(values[0])), max(high, float(values[-1]))
    most = max(abs(v) for v in values)
    powers = most >= 1_000_000 or most < Decimal("0.001")
    span = Axis(low, high, False, ())
    placed = (
        Tick(min(1.0, max(0.0, span.at(float(v)))), _written(v, max(0, -exponent), powers))
        for v in values
    )
    return Axis(low, high, False, tuple(placed))


def _step(rough: float) -> tuple[int, int]:
    """The round step nearest above: (1, 2, 5 or 25, the power of ten that it is times)."""
    exponent = math.floor(math.log10(rough))
    for mantissa, power in ((1, 0), (2, 0), (25, -1), (5, 0), (1, 1)):
        if Decimal(mantissa).scaleb(exponent + power) >= Decimal(rough) * Decimal("0.9999"):
            return mantissa, exponent + power
    return 1, exponent + 1


def _written(value: Decimal, decimals: int, powers: bool) -> str:
    if not value:
        return "0"
    if powers:
        digits = value.normalize()
        exponent = digits.adjusted()
        return signed(f"{digits.scaleb(-exponent).normalize():f}e{exponent}")
    return signed(f"{value:.{decimals}f}" if abs(value) < 10_000 else f"{value:,.{decimals}f}")
