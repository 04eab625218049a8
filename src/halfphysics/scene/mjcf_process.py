"""A compiled MuJoCo model of a stranger's file: read in a child process, the arrays come back."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.base import limited_child
from halfphysics.errors import InputError
from halfphysics.scene import mjcf_child

#: Time for MuJoCo to read and compile a file [s], and memory [bytes]; and for every byte of its
#: meshes and textures [s, bytes]. A robot of a hundred links takes 0.1 s, a MB of meshes 0.2 s.
SECONDS, MEMORY = 4.0, 2**30
SECONDS_PER_BYTE, MEMORY_PER_BYTE = 2e-6, 32
#: Bytes of the arrays that come back: a hundred meshes of 10,000 vertices are 12 MB.
_MOST_BYTES = 2**28
#: So many models of texts that name no files, each of so many bytes at most, are remembered: scenes
#: of scenarios and sweeps are built again and again, and a process takes half a second to start.
_REMEMBERED, _REMEMBERED_BYTES = 16, 2**20
#: The meaning of an error, by what MuJoCo was doing.
_EXPECTED = {
    "read": "MuJoCo cannot read it: {}. Expected MJCF or URDF",
    "compile": "MuJoCo cannot compile it: {}. Expected a model that MuJoCo itself loads, with its "
    "mesh files in their place and masses of all that moves",
}


@dataclass(frozen=True)
class CompiledModel:
    """The parts of a compiled model that are used, under MuJoCo's names.

    `names` has the counts (`nbody`, ...) and the lists `bodies` and `joints`; other attributes are
    its arrays.
    """

    names: dict[str, Any]
    arrays: dict[str, Any]

    def __getattr__(self, name: str) -> Any:
        for found in (self.names, self.arrays):
            if name in found:
                return found[name]
        raise AttributeError(name)


def compiled(
    what: str, source: dict[str, Any], *, assets: int = 0, reads_files: bool = True
) -> CompiledModel:
    """The model of a file or a text.

    Args:
        what: Name for messages.
        source: `path` or `xml`, `urdf`: whether it is URDF, and `files`: see `mjcf_child`.
        assets: Bytes of the meshes and textures that it names.
        reads_files: False: the source is all that there is to read, so that its model is compiled
            once in a process. The arrays are then shared and cannot be changed.

    Raises:
        InputError: MuJoCo cannot read or compile it, within `SECONDS` and `MEMORY`, or crashes.
    """
    request = json.dumps(source).encode()
    if not reads_files and request in _known:
        return _known[request]
    seconds, memory = SECONDS + SECONDS_PER_BYTE * assets, MEMORY + MEMORY_PER_BYTE * assets
    if not limited_child.can_start():
        head, arrays = mjcf_child.read(source)
    else:
        answer = limited_child.run(
            Path(mjcf_child.__file__),
            request,
            seconds=seconds,
            memory=memory,
        )
        if answer.failure:
            raise InputError(
                f"{what}: {answer.failure}, expected a model that MuJoCo reads within "
                f"{seconds:.0f} s of a processor and {memory / 2**30:.1f} GiB. Does it attach or "
                "replicate itself?"
            )
        head, arrays = _parsed(answer.output)
    if "error" in head:
        reason = " ".join(str(head["error"]).split())[:400]
        raise InputError(f"{what}: {_EXPECTED[head['in']].format(reason)}")
    model = CompiledModel(head, arrays)
    if not reads_files:
        _remember(request, model)
    return model


_known: dict[bytes, CompiledModel] = {}


def _remember(request: bytes, model: CompiledModel) -> None:
    for array in model.arrays.values():
        array.setflags(write=False)
    if len(request) + sum(array.nbytes for array in model.arrays.values()) > _REMEMBERED_BYTES:
        return
    while len(_known) >= _REMEMBERED:
        _known.pop(next(iter(_known)), None)
    _known[request] = model


def of_spec(spec: Any) -> CompiledModel:
    """The model of an MjSpec that the caller made; raises MuJoCo's own errors."""
    return CompiledModel(*mjcf_child.contents(spec.compile()))


def _parsed(output: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    head, _, packed = output.partition(b"\n")
    if not packed or len(packed) > _MOST_BYTES:
        return {"error": "its answer is damaged or too large", "in": "compile"}, {}
    with np.load(io.BytesIO(packed), allow_pickle=False) as file:
        return json.loads(head), {name: file[name] for name in file.files}
