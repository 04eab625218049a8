"""Stand-ins for what a restricted pickle may name: arrays of numpy, scipy and chumpy, containers.

Each answers one global name of a pickle with data. A `Placeholder` collects the state of an object
while the pickle is read, and becomes an array afterwards. The named package is never imported.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from halfphysics.base.pickle_budget import spend

#: Largest file that is read, and largest array that a sparse matrix may unfold to [bytes].
MAX_BYTES = 4 * 2**30
MAX_DENSE = 2**28
#: What a class counts for [bytes]: it takes as long to make as so much memory to fill.
_CLASS = 20_000

_SIMPLE_KINDS = "biufcSUO"


class Refused(Exception):
    """The pickle names an object that is not data; the text is the object's name."""


class Placeholder:
    """Stands for an object until its state has been read; `value` is what it becomes."""

    origin = "object"
    state: Any = None

    def __init__(self, *args: Any) -> None:
        pass

    def __setstate__(self, state: Any) -> None:
        self.state = state

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        raise Refused(f"{self.origin}: unknown contents")


class _Dtype(Placeholder):
    """numpy.dtype, built by numpy from its text; its own state is used for the byte order only."""

    origin = "numpy.dtype"

    def __init__(self, code: Any, *flags: Any) -> None:
        if not isinstance(code, str):
            raise Refused(f"numpy.dtype of {type(code).__name__}")
        self.dtype = np.dtype(code)
        self._check()

    def __setstate__(self, state: Any) -> None:
        order = state[1]
        if order not in ("<", ">", "|", "="):
            raise Refused(f"numpy.dtype with byte order {order!r}")
        if state[2] is not None or state[3] is not None or state[4] is not None:
            raise Refused("numpy.dtype with fields")
        if order in "<>":
            self.dtype = self.dtype.newbyteorder(order)
        self._check()

    def _check(self) -> None:
        if self.dtype.kind not in _SIMPLE_KINDS or self.dtype.names is not None:
            raise Refused(f"numpy.dtype {self.dtype}")

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        return self.dtype


class _Array(Placeholder):
    """numpy.ndarray."""

    origin = "numpy.ndarray"

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        _, shape, dtype, fortran, data = self.state
        if isinstance(data, list):
            data = [settle(item) for item in data]
        return _array(data, dtype, shape, "F" if fortran else "C")


class _Sparse(Placeholder):
    """scipy.sparse matrices in csc, csr or coo form -> dense arrays."""

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        state = {str(key).lstrip("_"): value for key, value in settle(dict(self.state)).items()}
        for key, value in state.items():
            # A list may name others until it is as long as it likes.
            plain = isinstance(value, (np.ndarray, str, int, float, type(None)))
            if not (plain or key == "shape" or (key == "coords" and len(value) == 2)):
                raise Refused(f"{self.origin} with {key} of {type(value).__name__}")
        rows, columns = (int(n) for n in state["shape"])
        data = np.asarray(state["data"])
        if data.dtype.kind not in "biuf":
            raise Refused(f"{self.origin} of {data.dtype}")
        if rows < 0 or columns < 0 or rows * columns * 8 > MAX_DENSE:
            raise Refused(f"{self.origin} of shape ({rows}, {columns}): too large")
        spend(rows * columns * 8)
        if "indptr" in state:
            pointers = np.asarray(state["indptr"])
            if pointers[0] != 0 or pointers[-1] != len(data) or np.any(np.diff(pointers) < 0):
                raise ValueError(f"{self.origin} with row pointers that do not fit its values")
            major = np.repeat(np.arange(len(pointers) - 1), np.diff(pointers))
            minor = np.asarray(state["indices"])
            i, j = (minor, major) if "csc" in self.origin else (major, minor)
        elif "coords" in state:
            i, j = (_numbers(self.origin, axis) for axis in state["coords"])
        else:
            i, j = np.asarray(state["row"]), np.asarray(state["col"])
        dense = np.zeros((rows, columns))
        if not len(i) == len(j) == len(data):
            raise ValueError(f"{self.origin} with {len(data)} values for {len(i)} places")
        if len(data):
            if min(i.min(), j.min()) < 0 or i.max() >= rows or j.max() >= columns:
                raise ValueError(f"{self.origin} with values outside its shape")
            np.add.at(dense, (i, j), data)
        return dense


class _Chumpy(Placeholder):
    """chumpy.ch.Ch (its array is `x`) and chumpy.reordering.Select (rows `idxs` of `a`)."""

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        state = self.state if isinstance(self.state, dict) else {}
        if "x" in state:
            return np.array(_numbers(self.origin, settle(state["x"])), dtype=np.float64)
        if "a" in state and "idxs" in state:
            whole = _numbers(self.origin, settle(state["a"]))
            places = _numbers(self.origin, settle(state["idxs"])).reshape(-1)
            flat = np.asarray(whole, dtype=np.float64).reshape(-1)
            picked = flat[np.asarray(places, dtype=np.int64)]
            shape = settle(state.get("preferred_shape"))
            return picked if shape is None else picked.reshape([int(n) for n in shape])
        raise Refused(f"{self.origin} (only plain arrays and selections of chumpy are read)")


def _numbers(origin: str, value: Any) -> np.ndarray:
    """An array of numbers of eight bytes each that is about to be copied.

    Lists are refused: they may name one another until they are as long as they like.
    """
    if not isinstance(value, (np.ndarray, np.generic, int, float)):
        raise Refused(f"{origin} of {type(value).__name__}")
    array = np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise Refused(f"{origin} of {array.dtype}")
    spend(8 * array.size)
    return array


class InLineArray(Placeholder):
    """joblib.numpy_pickle.NumpyArrayWrapper: the array's bytes follow in the file itself."""

    origin = "joblib.numpy_pickle.NumpyArrayWrapper"
    array: Any = None

    def read(self, stream: io.BytesIO, nested: Callable[[io.BytesIO], Any]) -> None:
        """Read the array from the stream, which is right behind the wrapper's own state.

        `nested` reads a pickle within the pickle: an array of objects is one.
        """
        state = dict(self.state)
        shape, dtype = tuple(int(n) for n in state["shape"]), state["dtype"]
        if not isinstance(dtype, _Dtype):
            raise Refused(f"{self.origin} with a type that is no numpy.dtype")
        if dtype.dtype.hasobject:
            self.array = nested(stream)
            return
        if state.get("numpy_array_alignment_bytes") is not None:
            stream.read(int.from_bytes(stream.read(1), "little"))
        count = 1
        for n in shape:
            count *= n
        if count < 0 or count > MAX_BYTES:
            raise ValueError(f"numpy.ndarray of shape {shape}")
        data = stream.read(count * dtype.dtype.itemsize)
        self.array = _array(data, dtype, shape, str(state["order"]))

    def resolve(self, settle: Callable[[Any], Any]) -> Any:
        return settle(self.array)


def _array(data: Any, dtype: Any, shape: Any, order: str) -> np.ndarray:
    """An array from raw bytes, or from a list where it holds objects; sizes must agree."""
    if not isinstance(dtype, _Dtype) or order not in ("C", "F"):
        raise Refused("numpy.ndarray with a type that is no numpy.dtype")
    shape = tuple(int(n) for n in shape)
    # A plain product of ints: numpy's own would wrap around.
    count = 1
    for n in shape:
        count *= n
    if min(shape, default=0) < 0 or len(shape) > 32:
        raise ValueError(f"numpy.ndarray of shape {shape}")
    if dtype.dtype.hasobject:
        if not isinstance(data, list) or len(data) != count:
            raise ValueError(f"numpy.ndarray of objects whose shape {shape} does not fit its list")
        spend(8 * count)
        array = np.empty(count, dtype=object)
        order = "C"  # numpy lists objects row by row, whatever the order in memory
        for i, item in enumerate(data):  # array[:] = data would unfold arrays of equal shape
            array[i] = item
    else:
        if isinstance(data, str):  # Python 2 wrote bytes as text
            data = data.encode("latin1")
        if len(data) != count * dtype.dtype.itemsize:
            raise ValueError(
                f"numpy.ndarray of shape {shape} and {dtype.dtype} with {len(data)} bytes"
            )
        spend(len(data))
        array = np.frombuffer(data, dtype=dtype.dtype, count=count).copy()
    result: np.ndarray = array.reshape(shape, order=order)  # type: ignore[call-overload]
    return result


def _frombuffer(data: Any, dtype: Any, shape: Any, order: Any) -> np.ndarray:
    return _array(data, dtype, (shape,) if isinstance(shape, int) else shape, order)


def _scalar(dtype: Any, data: Any) -> Any:
    return _array(data, dtype, (1,), "C")[0]


def _reconstruct(*args: Any) -> _Array:
    return _Array()


def _reconstructor(cls: Any, base: Any, state: Any) -> Any:
    """copyreg._reconstructor: how protocols 0 and 1 make an object."""
    if isinstance(cls, type) and issubclass(cls, Placeholder) and base is _Object:
        return cls()
    raise Refused("copyreg._reconstructor of something that is no data")


def _encode(text: str, encoding: str = "latin1") -> bytes:
    """_codecs.encode: how protocol 2 of Python 3 writes bytes."""
    if encoding not in ("latin1", "latin-1"):
        raise Refused(f"_codecs.encode with {encoding!r}")
    return text.encode("latin1")


def _bytes(*args: Any) -> bytes:
    # bytes(10**12) would allocate a terabyte.
    if args and not isinstance(args[0], (bytes, bytearray, list)):
        raise Refused(f"bytes of {type(args[0]).__name__}")
    return bytes(args[0]) if args else b""


def _bytearray(*args: Any) -> bytearray:
    if args and isinstance(args[0], str):
        return bytearray(args[0].encode("latin1"))
    return bytearray(_bytes(*args[:1]))


def _defaultdict(*args: Any) -> dict[Any, Any]:
    return {}


class _Object(Placeholder):
    """The class `object`: allowed as the base of a reconstruction only."""


_BUILTINS: dict[str, Any] = {
    "set": set, "frozenset": frozenset, "list": list, "tuple": tuple, "dict": dict,
    "int": int, "long": int, "float": float, "complex": complex, "bool": bool,
    "bytes": _bytes, "bytearray": _bytearray, "object": _Object,
}  # fmt: skip
_MULTIARRAY = {"_reconstruct": _reconstruct, "scalar": _scalar}
_NUMERIC = {"_frombuffer": _frombuffer}
GLOBALS: dict[str, dict[str, Any]] = {
    "builtins": _BUILTINS,
    "__builtin__": _BUILTINS,
    "collections": {"OrderedDict": dict, "defaultdict": _defaultdict},
    "copyreg": {"_reconstructor": _reconstructor},
    "copy_reg": {"_reconstructor": _reconstructor},
    "_codecs": {"encode": _encode},
    "numpy": {"ndarray": _Array, "dtype": _Dtype},
    "numpy.core.multiarray": _MULTIARRAY,
    "numpy._core.multiarray": _MULTIARRAY,
    "numpy.core.numeric": _NUMERIC,
    "numpy._core.numeric": _NUMERIC,
    "joblib.numpy_pickle": {"NumpyArrayWrapper": InLineArray},
}
_SPARSE_NAMES = {f"{form}_{kind}" for form in ("csc", "csr", "coo") for kind in ("matrix", "array")}


def global_of(module: str, name: str) -> Any:
    """The stand-in of `module.name`; None: there is none."""
    known = GLOBALS.get(module, {})
    if name in known:
        return known[name]
    origin = f"{module}.{name}"
    if module.split(".")[0] == "chumpy":
        spend(_CLASS)
        return _named(_Chumpy, origin)
    if module.startswith("scipy.sparse") and name in _SPARSE_NAMES:
        return _named(_Sparse, origin)
    return None


@lru_cache(maxsize=256)
def _named(kind: type[Placeholder], origin: str) -> type[Placeholder]:
    """The stand-in for a class of that name."""
    return type(kind.__name__, (kind,), {"origin": origin})
