"""Counter-based random numbers: each is a hash of its seed, name and number, not of a state.

A stream belongs to a seed and a name (of a factor), a draw to a stream and a number (of a
variant). The hash is BLAKE2b, and the later steps use only operations that IEEE 754 prescribes to
the last bit (no logarithm of a mathematics library: its last digit depends on the machine). So the
draws are the same on every platform.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from hashlib import blake2b

#: ln 2 in two parts: the product of the first part and a small integer is exact.
_LN2_HIGH = 0.693147180369123816490
_LN2_LOW = 1.90821492927058770002e-10
_LOG2_E = 1.4426950408889634
_ATANH = tuple(1.0 / (2 * k + 1) for k in range(11, -1, -1))
_TAYLOR = tuple(1.0 / math.factorial(k) for k in range(14, -1, -1))

_EIGHT = struct.Struct("<8Q")
_COUNTER = struct.Struct("<QQ")


class Stream:
    """The draws of one name under one seed."""

    def __init__(self, seed: int, name: str) -> None:
        self.seed, self.name = seed, name
        self._start = blake2b(f"{seed}\0{name}".encode(), digest_size=64, person=b"halfphysics")

    def __reduce__(self) -> tuple[type[Stream], tuple[int, str]]:
        return Stream, (self.seed, self.name)

    def uniform(self, number: int) -> float:
        """The number-th draw, uniform between 0 and 1 (both excluded)."""
        hashed = self._start.copy()
        hashed.update(_COUNTER.pack(number, 0))
        return _even(int.from_bytes(hashed.digest()[:8], "little"))

    def uniforms(self, number: int) -> Iterator[float]:
        """An endless sequence of uniform draws for `number`."""
        block = 0
        while True:
            hashed = self._start.copy()
            hashed.update(_COUNTER.pack(number, block))
            for word in _EIGHT.unpack(hashed.digest()):
                yield _even(word)
            block += 1

    def normals(self, number: int) -> Iterator[float]:
        """An endless sequence of standard normal draws for `number` (Marsaglia's method)."""
        even = self.uniforms(number)
        while True:
            x, y = 2.0 * next(even) - 1.0, 2.0 * next(even) - 1.0
            square = x * x + y * y
            if square < 1.0:  # x = y = 0 cannot be: 0.5 is never drawn
                scale = math.sqrt(-2.0 * log(square) / square)
                yield x * scale
                yield y * scale


def _even(word: int) -> float:
    """A number between 0 and 1 (both excluded) from 64 random bits, exact in double precision."""
    return ((word >> 12) + 0.5) * 2.0**-52


def log(x: float) -> float:
    """The natural logarithm of x > 0, to a few units in the last place, equal on every machine."""
    mantissa, exponent = math.frexp(x)
    if mantissa < 0.7071067811865476:
        mantissa, exponent = 2.0 * mantissa, exponent - 1
    s = (mantissa - 1.0) / (mantissa + 1.0)  # ln m = 2 atanh s, |s| < 0.172
    square, series = s * s, 0.0
    for term in _ATANH:
        series = series * square + term
    return exponent * _LN2_HIGH + (2.0 * s * series + exponent * _LN2_LOW)


def exp(x: float) -> float:
    """e to the power x (|x| < 700), to a few units in the last place, equal on every machine."""
    exponent = math.floor(x * _LOG2_E + 0.5)
    rest = (x - exponent * _LN2_HIGH) - exponent * _LN2_LOW  # |rest| < 0.35
    series = 0.0
    for term in _TAYLOR:
        series = series * rest + term
    return math.ldexp(series, exponent)
