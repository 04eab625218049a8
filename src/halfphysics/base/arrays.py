"""Arrays of other libraries as numpy's: the one place where numbers of a caller become arrays.

Tensors of torch are detached from their gradients and copied from the device; arrays of jax, of
data frames and of whatever has `__array__` or `__dlpack__` are read as numpy reads them. Lists may
hold them. Nothing of those libraries is imported.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: What is taken as it is.
_OWN = (np.ndarray, np.generic, int, float, str, bytes, type(None))
#: Dimensions that an array of numpy may have.
_MOST_DIMENSIONS = 64


def array_of(value: Any) -> Any:
    """`value`, or a numpy array of the tensor that it is; lists with tensors as lists of arrays.

    Raises:
        TypeError: A tensor that has no numbers on this machine (of torch's "meta" device, traced
            by jax).
    """
    if isinstance(value, _OWN):
        return value
    if isinstance(value, list | tuple):
        return [array_of(one) for one in value] if _holds_tensors(value) else value
    return _read(value) if _is_tensor(value) else value


def as_array(value: Any) -> NDArray[Any]:
    """`value` as an array of the type that it has. Raises TypeError or ValueError."""
    return np.asarray(array_of(value))


def scalar_of(value: Any) -> Any:
    """The number in an array or a tensor of no dimension; anything else as it is."""
    if isinstance(value, _OWN) and not isinstance(value, np.ndarray):
        return value
    try:
        array = array_of(value)
    except TypeError:
        return value
    return array.item() if isinstance(array, np.ndarray) and array.ndim == 0 else value


def _is_tensor(value: Any) -> bool:
    # A class has these methods too, and is no array.
    names = ("detach", "__array__", "__dlpack__")
    return not isinstance(value, type) and any(hasattr(value, name) for name in names)


def _holds_tensors(values: list[Any] | tuple[Any, ...], depth: int = 0) -> bool:
    if depth == _MOST_DIMENSIONS:  # numpy refuses it
        return False
    for one in values:
        if isinstance(one, list | tuple):
            if _holds_tensors(one, depth + 1):
                return True
        elif not isinstance(one, _OWN) and _is_tensor(one):
            return True
    return False


def _read(value: Any) -> NDArray[Any]:
    """The numbers of a tensor, on the processor and without gradients."""
    try:
        for method in ("detach", "cpu"):
            value = getattr(value, method)() if hasattr(value, method) else value
        return _standard(_to_numpy(value))
    except Exception as error:  # each library has its own
        raise TypeError(f"{type(value).__name__}: {error}") from None


def _to_numpy(value: Any) -> NDArray[Any]:
    if not hasattr(value, "__array__"):
        return np.from_dlpack(value)
    try:
        return np.asarray(value)
    except TypeError:
        # torch: numpy has no bfloat16; float32 holds all of its numbers.
        if not hasattr(value, "float"):
            raise
        return np.asarray(value.float())


def _standard(array: NDArray[Any]) -> NDArray[Any]:
    """Types of numbers that numpy itself does not have (jax's bfloat16, float8) as float32."""
    odd = array.dtype.kind == "V" and array.dtype.names is None
    return array.astype(np.float32) if odd else array
