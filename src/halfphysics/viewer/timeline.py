"""The clock of a viewer: play, pause, scrub, speed, step, loop. Pure; it draws nothing."""

from __future__ import annotations

import math
import threading
import time as _time
from collections.abc import Callable

from halfphysics.errors import InputError

#: Slowest and fastest playing, as parts of the motion's own rate.
SPEEDS = (0.1, 4.0)

# Of a frame: a time that is a frame's own is never a hair before it.
_EPS = 1e-6


class Timeline:
    """Time of one or several recordings that are looked at together.

    Recordings start together and share time in seconds; one that is shorter stays at its last
    frame. The time is worked out from the moment playing started, never added up: it does not
    drift. Safe to use from several threads.

    Args:
        *recordings: (frames, frames per second) of each.
        loop: Start again at the end.
        speed: Part of the motion's own rate, see `SPEEDS`.
        now: A clock [s].

    Attributes:
        recordings: As given.
        duration: Time of the last frame of the longest [s].
        fps: The highest frame rate: what `step` goes by.

    Raises:
        InputError: No recording, or one without frames or frame rate; an impossible speed.
    """

    def __init__(
        self,
        *recordings: tuple[int, float],
        loop: bool = True,
        speed: float = 1.0,
        now: Callable[[], float] = _time.monotonic,
    ) -> None:
        if not recordings:
            raise InputError("timeline: found no recordings, expected at least one")
        for frames, fps in recordings:
            if frames < 1 or not (math.isfinite(fps) and fps > 0.0):
                raise InputError(
                    f"timeline: found {frames} frames at {fps} per second, expected at least one "
                    "at a rate above 0"
                )
        self.recordings = tuple((int(frames), float(fps)) for frames, fps in recordings)
        self.duration = max((frames - 1) / fps for frames, fps in self.recordings)
        self.fps = max(fps for _, fps in self.recordings)
        self._now = now
        self._lock = threading.RLock()
        self._loop = bool(loop)
        self._speed = _checked_speed(speed)
        self._playing = False
        # The time was `_start` when the clock said `_since`.
        self._start, self._since = 0.0, now()

    @property
    def time(self) -> float:
        """Where it is [s], 0 to `duration`; in a loop the last frame stays as long as others do."""
        with self._lock:
            self._settle()
            return min(self._raw(), self.duration)

    @property
    def playing(self) -> bool:
        """Whether time goes on; without a loop it stops at the end."""
        with self._lock:
            self._settle()
            return self._playing

    @property
    def speed(self) -> float:
        """Part of the motion's own rate."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        speed = _checked_speed(speed)
        with self._lock:
            self._anchor(self._raw())
            self._speed = speed

    @property
    def loop(self) -> bool:
        """Whether it starts again at the end."""
        return self._loop

    @loop.setter
    def loop(self, loop: bool) -> None:
        with self._lock:
            self._anchor(self._raw())
            self._loop = bool(loop)

    def play(self) -> None:
        """Go on; from the end, start again."""
        with self._lock:
            self._settle()
            if not self._playing:
                at_end = self._start >= self.duration - _EPS / self.fps
                self._anchor(0.0 if at_end else self._start)
                self._playing = True

    def pause(self) -> None:
        """Stay where it is."""
        with self._lock:
            self._settle()
            self._anchor(min(self._raw(), self.duration))
            self._playing = False

    def toggle(self) -> None:
        """Play, or pause."""
        with self._lock:
            if self.playing:
                self.pause()
            else:
                self.play()

    def seek(self, time: float) -> None:
        """Go to a time [s]; before the start or after the end is there. Playing goes on."""
        with self._lock:
            self._anchor(min(max(float(time), 0.0), self.duration))

    def step(self, frames: int = 1) -> None:
        """Pause and go some frames on, or back if negative; in a loop, round the ends."""
        with self._lock:
            self.pause()
            last = round(self.duration * self.fps)
            frame = math.floor(self._start * self.fps + _EPS) + int(frames)
            frame = frame % (last + 1) if self._loop else min(max(frame, 0), last)
            self._anchor(frame / self.fps)

    def frame(self, recording: int = 0) -> int:
        """The frame of a recording that is shown now."""
        return self._frame_at(recording, self.time)

    def frames(self) -> tuple[int, ...]:
        """The frames of all recordings at one moment."""
        time = self.time
        return tuple(self._frame_at(k, time) for k in range(len(self.recordings)))

    def until_next(self) -> float:
        """Clock time until a frame of any recording changes [s]; inf while paused."""
        with self._lock:
            if not self.playing:
                return math.inf
            time = self._raw()
            changes = [self._period() if self._loop else self.duration]
            for frames, fps in self.recordings:
                following = math.floor(time * fps + _EPS) + 1
                if following < frames:
                    changes.append(following / fps)
            return max(min(changes) - time, 0.0) / self._speed

    def _frame_at(self, recording: int, time: float) -> int:
        frames, fps = self.recordings[recording]
        return min(math.floor(time * fps + _EPS), frames - 1)

    def _period(self) -> float:
        return self.duration + 1.0 / self.fps

    def _raw(self) -> float:
        """The time, which in a loop may be after the last frame."""
        if not self._playing:
            return self._start
        time = self._start + (self._now() - self._since) * self._speed
        return time % self._period() if self._loop else min(time, self.duration)

    def _anchor(self, time: float) -> None:
        self._start, self._since = time, self._now()

    def _settle(self) -> None:
        """Without a loop, stop at the end."""
        if self._playing and not self._loop and self._raw() >= self.duration:
            self._anchor(self.duration)
            self._playing = False


def _checked_speed(speed: float) -> float:
    low, high = SPEEDS
    if not low <= speed <= high:
        raise InputError(f"speed: found {speed!r}, expected {low:g} to {high:g}")
    return float(speed)
