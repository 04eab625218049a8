"""Numbers, units and arbitrary names as text of the report."""

from __future__ import annotations

import math
import unicodedata
from decimal import Decimal
from typing import Any

#: The text for a missing number.
MISSING = "–"


def plain(text: object) -> str:
    """One line of text without control characters or marks of direction.

    As `visible`; white space of any length becomes one blank.
    """
    return " ".join(visible(text).split())


def visible(text: object) -> str:
    """The text with every character visible.

    Control characters, marks of direction and lone surrogates (from file names that are no UTF-8)
    become U+FFFD; white space characters become blanks.
    """
    return "".join(
        " " if c.isspace() else "\ufffd" if unicodedata.category(c) in ("Cc", "Cf", "Cs") else c
        for c in str(text)
    )


def number(value: Any, *, beside: Any = None) -> str:
    """A value with its significant digits.

    Args:
        value: A number, None, a truth value or a text.
        beside: The number of the paper, if there is one: ours then has at least its decimals, so
            that both compare at a glance.
    """
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, int | float):
        return plain(value) or MISSING
    if isinstance(value, int):
        return _grouped(str(value))
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0:
        return "0"
    size = abs(value)
    if not 1e-4 <= size < 1e7:
        mantissa, exponent = f"{value:.2e}".split("e")
        return f"{_trimmed(mantissa)}e{int(exponent)}"
    decimals = max(0, 3 - math.floor(math.log10(size)))
    least = 0
    if isinstance(beside, int | float) and math.isfinite(beside) and beside:
        # At most six digits, whatever the decimals of the paper.
        most = max(0, 5 - math.floor(math.log10(size)))
        least = min(max(0, -_exponent(float(beside))), most)
    whole, _, rest = f"{value:.{max(decimals, least)}f}".partition(".")
    rest = rest[:least] + rest[least:].rstrip("0")
    return _grouped(f"{whole}.{rest}" if rest else whole)


def published(value: Any) -> str:
    """A number as the paper prints it, with all its digits."""
    if isinstance(value, float) and math.isfinite(value) and 1e-4 <= abs(value) < 1e7:
        return _grouped(_trimmed(format(Decimal(repr(value)), "f")))
    return number(value)


def signed(digits: str) -> str:
    """A number as it is typeset: with a minus, not a hyphen, before it."""
    return "−" + digits[1:] if digits.startswith("-") else digits


def quantity(label: str, unit: str) -> str:
    """A measure with its unit: `distance [mm]`."""
    label, unit = plain(label), plain(unit)
    if not unit:
        return label
    return f"{label} [{unit}]" if label else f"[{unit}]"


def _exponent(value: float) -> int:
    """The power of ten of the last digit of a number."""
    exponent = Decimal(repr(value)).normalize().as_tuple().exponent
    return exponent if isinstance(exponent, int) else 0


def _trimmed(digits: str) -> str:
    return digits.rstrip("0").rstrip(".") if "." in digits else digits


def _grouped(digits: str) -> str:
    """Commas in a number of five digits or more before the point."""
    whole, point, rest = digits.partition(".")
    if len(whole.lstrip("-")) > 4:
        whole = f"{int(whole):,}"
    return f"{whole}{point}{rest}"
