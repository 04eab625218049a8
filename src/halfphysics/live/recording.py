"""A live session as a result file, safe from whatever ends the process.

Frames are appended to FILE.unfinished twice a second, each block whole or not there
(`formats/results/unfinished.py`); when the session ends, that becomes the result file. A thread of
its own writes: stepping only hands frames over.
"""

from __future__ import annotations

import logging
import os
import queue
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.formats.results import unfinished
from halfphysics.formats.results.keys import BREACHES, CONTACT, INSIDE
from halfphysics.formats.results.result_writer import settings_document
from halfphysics.live.incoming import Outgoing
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.records import BodyRecord, SceneRecord
from halfphysics.results.result import DIAGNOSTICS
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.results.table import Table

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.frame import Frame
    from halfphysics.simulation.simulator import Simulator

logger = logging.getLogger(__name__)

#: Time between two blocks [s].
_EVERY = 0.5
#: Frames that wait for a disk that does not keep up; more are left out and counted.
_WAITING = 2000


class Recorder:
    """Writes the frames of a session.

    Args:
        path: The result file to write.
        simulator: What is recorded; it has been reset.

    Attributes:
        path: The result file.
        partial: The file that is appended to until then.
        left_out: Frames that the disk was too slow for.
        written: The file that has the recording, once it is closed: `path`, or `partial` where that
            could not be written; None: there was nothing to record.

    Raises:
        FileError: The folder is missing or cannot be written, or an earlier recording of this name
            was not finished.
    """

    def __init__(self, path: Path, simulator: Simulator) -> None:
        self.path = file_path(path)
        self.partial = self.path.with_name(f"{self.path.name}.unfinished")
        self.left_out = 0
        self.written: Path | None = None
        self._simulator = simulator
        self._frames: queue.Queue[tuple[Outgoing, Scene] | None] = queue.Queue(_WAITING)
        self._scene: Scene | None = None
        try:
            self._file = self.partial.open("xb", buffering=0)
        except FileExistsError:
            raise FileError(
                f"{self.partial}: found an earlier recording that was not finished. Read it with "
                "halfphysics convert or Result.load, then remove it"
            ) from None
        except OSError as error:
            raise FileError(f"{self.partial}: cannot write: {error.strerror}") from None
        try:
            self._file.write(unfinished.MAGIC)
            unfinished.write_document(self._file, unfinished.HEAD, _head(simulator))
        except OSError as error:
            self._file.close()
            self.partial.unlink(missing_ok=True)
            raise FileError(f"{self.partial}: cannot write: {error.strerror}") from None
        self._written = False  # some frames
        self._thread = threading.Thread(target=self._run, name="halfphysics-record", daemon=True)
        self._thread.start()

    def add(self, frame: Outgoing) -> None:
        """A listener of the session: take a frame; never waits."""
        try:
            self._frames.put_nowait((frame, self._simulator.world.made_of))
        except queue.Full:
            self.left_out += 1

    def close(self) -> None:
        """Write the result file and remove the unfinished one.

        If there is one frame only, or it cannot be written, the unfinished file stays; one without
        frames, of a session that did not start, is removed: it would stop the next one.
        """
        self._frames.put(None)
        self._thread.join()
        self._file.close()
        if not self._written:
            self.partial.unlink(missing_ok=True)
            return
        self.written = self.partial
        try:
            unfinished.load_unfinished(self.partial).save(self.path)
        except HalfPhysicsError as error:
            logger.warning("the recording stays as it is: %s", error)
            return
        self.written = self.path
        self.partial.unlink()

    # -- by the thread that writes -------------------------------------------------------

    def _run(self) -> None:
        ended = False
        while not ended:
            frames, ended = self._gathered()
            end = self._file.tell()
            try:
                self._append(frames)
            except OSError as error:
                logger.warning("%s: cannot write: %s", self.partial, error.strerror)
                self._leave_out(frames, end)
            except Exception:  # a fault of ours: what comes later is recorded all the same
                logger.exception("%s: frames cannot be recorded", self.partial)
                self._leave_out(frames, end)

    def _append(self, frames: list[tuple[Outgoing, Scene]]) -> None:
        for scene, some in _by_scene(frames):
            if scene is not self._scene:
                document = dict(SceneRecord.of(scene).document)
                unfinished.write_document(self._file, unfinished.SCENE, document)
                self._scene = scene
            unfinished.write_frames(self._file, _fields(some))
        os.fsync(self._file.fileno())
        self._written = self._written or bool(frames)

    def _leave_out(self, frames: list[tuple[Outgoing, Scene]], end: int) -> None:
        """Take away what was written of them: nothing is read behind a block that is cut off."""
        self.left_out += len(frames)
        self._scene = None
        try:
            self._file.seek(end)
            self._file.truncate()
        except OSError as error:
            logger.warning("%s: cannot write: %s", self.partial, error.strerror)

    def _gathered(self) -> tuple[list[tuple[Outgoing, Scene]], bool]:
        """The frames of the next block, and whether there are no more."""
        frames: list[tuple[Outgoing, Scene]] = []
        first = self._frames.get()
        while first is not None:
            frames.append(first)
            if frames[-1][0].clock - frames[0][0].clock >= _EVERY:
                return frames, False
            try:
                first = self._frames.get(timeout=_EVERY)
            except queue.Empty:
                return frames, False
        return frames, True


def _by_scene(frames: list[tuple[Outgoing, Scene]]) -> list[tuple[Scene, list[Outgoing]]]:
    """Runs of frames with the same scene."""
    runs: list[tuple[Scene, list[Outgoing]]] = []
    for frame, scene in frames:
        if not runs or runs[-1][0] is not scene:
            runs.append((scene, []))
        runs[-1][1].append(frame)
    return runs


def _head(simulator: Simulator) -> dict[str, Any]:
    return {
        "fps": 1.0 / simulator.dt,
        "settings": settings_document(simulator.settings),
        "people": [
            {
                "name": person.name,
                "gender": body.gender if body.gender != "unknown" else "neutral",
                "model": body.model if body.model in ("smplx", "smplh", "smpl") else "smplx",
                "axes": np.eye(3).tolist(),
                "betas": None,
                "body": dict(BodyRecord.of(body).data),
            }
            for person, body in zip(simulator.world.people, simulator.bodies, strict=True)
        ],
    }


def _fields(frames: list[Outgoing]) -> dict[str, NDArray[Any]]:
    """Arrays of some frames of one scene."""
    fields: dict[str, NDArray[Any]] = {
        "names": np.array(frames[0].names, dtype=np.str_),
        "clearance": np.array([frame.clearance for frame in frames]),
    }
    for i, name in enumerate(frames[0].poses):
        at = f"person/{i}/"
        poses, targets = [f.poses[name] for f in frames], [f.targets[name] for f in frames]
        fields[f"{at}translation"] = np.stack([pose.translation for pose in poses])
        fields[f"{at}rotations"] = np.stack([pose.rotations for pose in poses])
        fields[f"{at}target_translation"] = np.stack([pose.translation for pose in targets])
        fields[f"{at}target_rotations"] = np.stack([pose.rotations for pose in targets])
        fields[f"{at}torque"] = np.stack([_simulated(f).torques[i] for f in frames])
        fields[f"{at}corrected"] = np.array([_simulated(f).corrected[i] for f in frames])
    for name in frames[0].objects:
        fields[f"object/{name}/position"] = np.stack([f.objects[name][0] for f in frames])
        fields[f"object/{name}/quaternion"] = np.stack([f.objects[name][1] for f in frames])
    for name in frames[0].joints:
        fields[f"joint/{name}"] = np.stack([np.asarray(f.joints[name]) for f in frames])
    simulated = [_simulated(frame) for frame in frames]
    fields["lost_time"] = np.array([frame.lost_time for frame in simulated])
    for name in DIAGNOSTICS:
        fields[f"diagnostics/{name}"] = np.array(
            [float(frame.diagnostics.get(name, 0.0)) for frame in simulated]
        )
    return (
        fields
        | _columns(CONTACT, Contacts, [frame.contacts for frame in frames])
        | _columns(INSIDE, Inside, [frame.inside for frame in simulated])
        | _columns(BREACHES, Breaches, [frame.breaches for frame in simulated])
        | _pressure_columns(simulated)
    )


def _columns(prefix: str, of: type[Table], tables: Sequence[Any]) -> dict[str, NDArray[Any]]:
    """Columns of a table `of` the frames, from those of each."""
    counts = [len(table.part) for table in tables]
    columns = {f"{prefix}frame": np.repeat(np.arange(len(tables)), counts)}
    for name in of.columns():
        if name != "frame":
            columns[f"{prefix}{name}"] = np.concatenate([getattr(t, name) for t in tables])
    return columns


def _pressure_columns(simulated: list[Frame]) -> dict[str, NDArray[Any]]:
    """Samples under pressure, and how many each frame has; nothing where nothing is soft."""
    tables = [frame.soft_contacts for frame in simulated]
    there = [table for table in tables if table is not None]
    if not there:
        return {}
    columns: dict[str, NDArray[Any]] = {
        "pressed/count": np.array([0 if table is None else len(table) for table in tables])
    }
    for name in SoftContacts.columns():
        if name != "frame":
            values = np.concatenate([getattr(table, name) for table in there])
            # Simulators give numbers of single precision.
            kind = np.float32 if values.dtype.kind == "f" else np.int32
            columns[f"pressed/{name}"] = values.astype(kind)
    return columns


def _simulated(frame: Outgoing) -> Frame:
    if frame.simulated is None:
        raise ValueError("a frame that no simulator made cannot be recorded")
    return frame.simulated
