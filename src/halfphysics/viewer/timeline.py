"""The clock of a viewer: play, pause, scrub, speed, step, loop. It draws nothing."""

from __future__ import annotations

import math
import threading
import time as _time
from collections.abc import Callable

from halfphysics.errors import InputError

#: Smallest and largest speed, in multiples of the motion's own rate.
SPEEDS = (0.1, 4.0)

# Tolerance in frames, so that rounding never assigns a frame's time to the frame before.
_EPS = 1e-6


class Timeline:
    """The common time of one or several recordings.

    Recordings start together and share time in seconds; a shorter one stays at its last frame.
    The time is computed from the start of playing, not accumulated, so that it does not drift.
    Thread-safe.

    Args:
        *recordings: (number of frames, frames per second) of each.
        loop: Start again at the end.
        speed: Multiple of the motion's own rate, see `SPEEDS`.
        now: A clock [s].

    Attributes:
        recordings: The recordings.
        duration: Time of the last frame of the longest recording [s].
        fps: The highest frame rate, which `step` uses.

    Raises:
        InputError: No recording, one without frames or frame rate, or an invalid speed.
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
        # The time was `_start` when the clock read `_since`.
        self._start, self._since = 0.0, now()

    @property
    def time(self) -> float:
        """Present time [s], 0 to `duration`; in a loop the last frame lasts as long as others."""
        with self._lock:
            self._settle()
            return min(self._raw(), self.duration)

    @property
    def playing(self) -> bool:
        """Whether time advances; without a loop it stops at the end."""
        with self._lock:
            self._settle()
            return self._playing

    @property
    def speed(self) -> float:
        """Multiple of the motion's own rate."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        speed = _checked_speed(speed)
        with self._lock:
            self._anchor(self._raw())
            self._speed = speed

    @property
    def loop(self) -> bool:
        """Whether playing starts again at the end."""
        return self._loop

    @loop.setter
    def loop(self, loop: bool) -> None:
        with self._lock:
            self._anchor(self._raw())
            self._loop = bool(loop)

    def play(self) -> None:
        """Start playing; at the end, from the beginning."""
        with self._lock:
            self._settle()
            if not self._playing:
                at_end = self._start >= self.duration - _EPS / self.fps
                self._anchor(0.0 if at_end else self._start)
                self._playing = True

    def pause(self) -> None:
        """Stop at the present time."""
        with self._lock:
            self._settle()
            self._anchor(min(self._raw(), self.duration))
            self._playing = False

    def toggle(self) -> None:
        """Switch between playing and pause."""
        with self._lock:
            if self.playing:
                self.pause()
            else:
                self.play()

    def seek(self, time: float) -> None:
        """Go to a time [s], clipped to the duration. Playing goes on."""
        with self._lock:
            self._anchor(min(max(float(time), 0.0), self.duration))

    def step(self, frames: int = 1) -> None:
        """Pause and go `frames` forward, or back if negative; a loop wraps around."""
        with self._lock:
            self.pause()
            last = round(self.duration * self.fps)
            frame = math.floor(self._start * self.fps + _EPS) + int(frames)
            frame = frame % (last + 1) if self._loop else min(max(frame, 0), last)
            self._anchor(frame / self.fps)

    def frame(self, recording: int = 0) -> int:
        """The present frame of a recording."""
        return self._frame_at(recording, self.time)

    def frames(self) -> tuple[int, ...]:
        """The present frames of all recordings, at the same time."""
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
        """The unclipped time: in a loop it may be after the last frame."""
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
