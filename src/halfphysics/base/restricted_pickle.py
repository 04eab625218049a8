"""Unpickling files of strangers: data comes out, nothing is run.

A pickle is a program: it names any function of any module and calls it. Here it may name only what
`_globals` lists, each answered by a function or class of this file that builds numpy arrays,
numbers, strings and containers, or by the plain containers themselves. Everything else is refused
by name, before anything of it is looked up. Sparse matrices of scipy and arrays of chumpy become
numpy arrays without importing either.

It stands on the interpreter's own pure-Python unpickler, whose table of operations can be cut; the
C one trusts sizes written in the file (a 20-byte file can ask it for gigabytes).
"""

from __future__ import annotations

import io
import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from halfphysics.errors import FileError

#: Largest file that is read, and largest array that a sparse matrix may unfold to [bytes].
MAX_BYTES = 4 * 2**30
MAX_DENSE = 2**30

_SIMPLE_KINDS = "biufcSUO"


# Arrays of objects in a joblib dump are pickles of their own, which may hold such arrays again.
_MAX_DEPTH = 8


class Refused(Exception):
    """The pickle wants something that is not data; the text says what."""


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


@dataclass(frozen=True, kw_only=True)
class Guests:
    """What a format built on pickles (torch) names: functions and classes of ours that stand for
    its own, by module and name, and what its persistent objects are."""

    globals: Mapping[str, Mapping[str, Any]]
    persistent: Callable[[Any], Any]


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
        rows, columns = (int(n) for n in state["shape"])
        data = np.asarray(state["data"])
        if data.dtype.kind not in "biuf":
            raise Refused(f"{self.origin} of {data.dtype}")
        if rows < 0 or columns < 0 or rows * columns * 8 > MAX_DENSE:
            raise Refused(f"{self.origin} of shape ({rows}, {columns}): too large")
        if "indptr" in state:
            pointers = np.asarray(state["indptr"])
            if pointers[0] != 0 or pointers[-1] != len(data) or np.any(np.diff(pointers) < 0):
                raise ValueError(f"{self.origin} with row pointers that do not fit its values")
            major = np.repeat(np.arange(len(pointers) - 1), np.diff(pointers))
            minor = np.asarray(state["indices"])
            i, j = (minor, major) if "csc" in self.origin else (major, minor)
        elif "coords" in state:
            i, j = (np.asarray(axis) for axis in state["coords"])
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
            return np.array(settle(state["x"]), dtype=np.float64)
        if "a" in state and "idxs" in state:
            flat = np.asarray(settle(state["a"]), dtype=np.float64).reshape(-1)
            picked = flat[np.asarray(settle(state["idxs"]), dtype=np.int64).reshape(-1)]
            shape = settle(state.get("preferred_shape"))
            return picked if shape is None else picked.reshape([int(n) for n in shape])
        raise Refused(f"{self.origin} (only plain arrays and selections of chumpy are read)")


class _InLine(Placeholder):
    """joblib.numpy_pickle.NumpyArrayWrapper: the array's bytes follow in the file itself."""

    origin = "joblib.numpy_pickle.NumpyArrayWrapper"
    array: Any = None

    def read(self, stream: io.BytesIO, depth: int) -> None:
        """Takes the array off the stream, which stands right behind the wrapper's own state."""
        state = dict(self.state)
        shape, dtype = tuple(int(n) for n in state["shape"]), state["dtype"]
        if not isinstance(dtype, _Dtype):
            raise Refused(f"{self.origin} with a type that is no numpy.dtype")
        if dtype.dtype.hasobject:
            self.array = _Unpickler(stream, depth=depth + 1).load()  # a pickle of its own
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
        array = np.frombuffer(bytes(data), dtype=dtype.dtype, count=count).copy()
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
_GLOBALS: dict[str, dict[str, Any]] = {
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
    "joblib.numpy_pickle": {"NumpyArrayWrapper": _InLine},
}
_SPARSE_NAMES = {f"{form}_{kind}" for form in ("csc", "csr", "coo") for kind in ("matrix", "array")}


_PythonUnpickler: Any = pickle._Unpickler


class _Unpickler(_PythonUnpickler):  # type: ignore[misc]
    """The interpreter's unpickler, cut down to data."""

    dispatch: ClassVar[dict[int, Any]] = dict(_PythonUnpickler.dispatch)

    def __init__(self, stream: io.BytesIO, guests: Guests | None = None, depth: int = 0) -> None:
        if depth > _MAX_DEPTH:
            raise ValueError("pickles within pickles")
        super().__init__(stream, encoding="latin1")
        self._stream = stream
        self._guests = guests
        self._depth = depth

    def find_class(self, module: str, name: str) -> Any:
        known = _GLOBALS.get(module, {})
        if self._guests is not None:
            known = {**known, **self._guests.globals.get(module, {})}
        if name in known:
            return known[name]
        origin = f"{module}.{name}"
        if module.split(".")[0] == "chumpy":
            return type("_Chumpy", (_Chumpy,), {"origin": origin})
        if module.startswith("scipy.sparse") and name in _SPARSE_NAMES:
            return type("_Sparse", (_Sparse,), {"origin": origin})
        raise Refused(origin)

    def persistent_load(self, pid: Any) -> Any:
        if self._guests is None:
            raise Refused("a persistent object")
        return self._guests.persistent(pid)

    def get_extension(self, code: int) -> None:
        raise Refused(f"the registered extension {code}")

    def load_build(self) -> None:
        # Only on placeholders: the original sets attributes on anything, classes included.
        state = self.stack.pop()
        target = self.stack[-1]
        if not isinstance(target, Placeholder):
            raise Refused(f"setting the state of {type(target).__name__}")
        target.__setstate__(state)
        if isinstance(target, _InLine):
            target.read(self._stream, self._depth)

    def load_bytearray8(self) -> None:
        # The original allocates the size that the file claims before it reads.
        size = int.from_bytes(self.read(8), "little")
        self.append(bytearray(self.read(size)))

    dispatch[pickle.BUILD[0]] = load_build
    dispatch[pickle.BYTEARRAY8[0]] = load_bytearray8


def _settled(root: Any) -> Any:
    """`root` with every placeholder in it replaced by its value, shared objects kept shared."""
    done: dict[int, Any] = {}
    alive: list[Any] = []  # ids stay unique only while their objects live
    busy = object()

    def settle(value: Any) -> Any:
        if not isinstance(value, (dict, list, tuple, set, frozenset, Placeholder)):
            if callable(value):
                raise Refused("a class or function in place of data")
            return value
        key = id(value)
        if key in done:
            if done[key] is busy:
                raise ValueError("an object that contains itself")
            return done[key]
        alive.append(value)
        # Lists and dicts are filled in place, so that they may contain themselves.
        done[key] = value if isinstance(value, (dict, list)) else busy
        if isinstance(value, Placeholder):
            done[key] = value.resolve(settle)
        elif isinstance(value, dict):
            for name in value:
                value[plain(name)] = settle(value[name])
        elif isinstance(value, list):
            value[:] = [settle(item) for item in value]
        elif isinstance(value, tuple):
            done[key] = tuple(settle(item) for item in value)
        else:
            done[key] = type(value)(plain(item) for item in value)
        return done[key]

    def plain(value: Any) -> Any:
        """Keys and members of sets: numbers, strings, tuples."""
        if isinstance(value, Placeholder) or callable(value):
            raise Refused(f"{type(value).__name__} as a key")
        if isinstance(value, (tuple, frozenset)):
            for item in value:
                plain(item)
        return value

    return settle(root)


def loads(
    data: bytes, name: str | os.PathLike[str] = "pickle", guests: Guests | None = None
) -> Any:
    """The data of a pickle in memory; `name` is what messages call it.

    `guests`: what a format that is built on pickles names besides.

    Raises:
        FileError: It holds or calls anything but data, or is damaged or truncated.
    """
    try:
        return _settled(_Unpickler(io.BytesIO(data), guests).load())
    except Refused as refused:
        raise FileError(
            f"{name}: unsafe or unknown content: the pickle names {refused}. Read are only numpy "
            "arrays, numbers, strings, containers, scipy.sparse matrices and chumpy arrays; "
            "nothing was run. If you trust the file, save its arrays as .npz"
        ) from None
    except (RecursionError, MemoryError) as error:
        raise FileError(f"{name}: nested too deeply or too large ({error!r})") from None
    except Exception as error:  # a damaged pickle can fail in any way that Python knows
        raise FileError(
            f"{name}: not a readable pickle ({type(error).__name__}: {error}). Is it truncated? "
            "Download or copy the file again"
        ) from None


def load(path: str | os.PathLike[str]) -> Any:
    """The data of a pickle file.

    Returns:
        Numbers, strings, bytes, numpy arrays (also for scipy.sparse and chumpy), and lists,
        tuples, sets and dicts of those.

    Raises:
        FileError: The file cannot be read, is larger than `MAX_BYTES`, holds or calls anything
            but data, or is damaged.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise FileError(
                f"{path}: {size / 2**30:.1f} GiB, expected at most {MAX_BYTES / 2**30:.0f} GiB "
                "in one pickle"
            )
        data = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    return loads(data, path)
