"""halfphysics send: a clip in real time, as a live protocol's sender."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

import tyro

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number
from halfphysics.cli.options import BodyOptions, MotionOptions
from halfphysics.errors import InputError
from halfphysics.motion.resampling import sample_positions

if TYPE_CHECKING:
    from collections.abc import Iterator

    from halfphysics.body.body import Body
    from halfphysics.live.incoming import Sender
    from halfphysics.motion.motion import Motion

EXAMPLES = """\
halfphysics send walk.npz --as vmc
halfphysics send walk.npz --as ws://127.0.0.1:8765 --loop
halfphysics send walk.npz --as mocopi:12351 --as rokoko --to-fps 60
halfphysics send walk.npz --as vmc:192.168.0.7:39539 --remote --speed 0.5"""

#: Name of the person in what is sent.
PERSON = "person0"

Repeated = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


@dataclass(frozen=True, kw_only=True)
class Command:
    """Play a motion file in real time, as motion capture programs send it: to a live session
    (halfphysics serve), to Unity, Blender, VSeeFace, for tests and demos.

    Protocols: ws (a live session), vmc, mocopi, xsens, rokoko, sonic. Ctrl-C ends it.
    """

    source: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="CLIP")]
    """Motion or result file."""
    as_: Annotated[Repeated, tyro.conf.arg(name="as", metavar="PROTOCOL:HOST:PORT")]
    """How and where to, such as vmc, vmc:39539, ws://127.0.0.1:8765; may be repeated."""
    to_fps: float | None = None
    """Frames per second that are sent; the clip's if not given."""
    speed: float = 1.0
    """How fast the clip goes: 2 is twice as fast."""
    loop: bool = False
    """Start again at the end of the clip, until Ctrl-C."""
    for_: Annotated[float | None, tyro.conf.arg(name="for", metavar="SECONDS")] = None
    """End after this time [s]."""
    remote: bool = False
    """Allow to send to other machines."""
    to: Annotated[str | None, tyro.conf.arg(metavar="PERSON")] = None
    """Name of the person in a live session; its first if not given."""
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Send until the end of the clip or Ctrl-C."""
        from halfphysics.live.playback import play

        if not self.as_:
            raise InputError("send: found no --as. Say how and where to, such as --as vmc")
        for text in self.as_:
            self._check(text)
        self._check_numbers()
        motion = self.motion_file.load(self.source)
        self._check_frames(motion)
        body = self.person.instead_of(self._own_body(), motion)
        with self._senders(body) as senders:
            print(f"{self.source} to {', '.join(self.as_)}", flush=True)
            played = play(
                motion.rebased(body),
                senders,
                person=PERSON,
                fps=self.to_fps,
                speed=self.speed,
                loop=self.loop,
                seconds=self.for_,
            )
        print(f"{played.frames} frames in {played.seconds:.2f} s, {played.late} left out")

    def _check(self, text: str) -> None:
        """That a protocol is known, and its address one that may be sent to."""
        from halfphysics.live.protocols import SENDERS, endpoint_of
        from halfphysics.live.safety import is_loopback

        name = text.partition(":")[0]
        if name not in ("ws", "wss", *SENDERS):
            hint = did_you_mean(name, ("ws", *SENDERS), otherwise=".")
            raise InputError(
                f"--as {text}: the protocol {name!r} is not known{hint} Expected one of "
                f"{', '.join(('ws', *SENDERS))}"
            )
        if name in ("ws", "wss"):
            host = urlsplit(_url(text)).hostname or ""
            local = is_loopback(host)
        else:
            where = endpoint_of(text)
            host, local = where.host, where.is_local
        if not local and not self.remote:
            raise InputError(
                f"--as {text}: found another machine ({host!r}), expected this one's loopback. Add "
                "--remote to send there"
            )

    def _check_numbers(self) -> None:
        number(self.speed, "--speed", above=0.0, most=100.0)
        if self.for_ is not None:
            number(self.for_, "--for", above=0.0, unit="s")
        if self.to_fps is not None:
            number(self.to_fps, "--to-fps", above=0.0)

    def _check_frames(self, motion: Motion) -> None:
        """That the clip has frames at the rate and the speed."""
        rate = motion.fps if self.to_fps is None else self.to_fps
        try:
            sample_positions(len(motion), motion.fps, rate / self.speed)
        except InputError as error:
            said = str(error).removeprefix("fps: ")
            asked = f"--to-fps {rate:g}, divided by --speed {self.speed:g}"
            raise InputError(f"{asked}: {said}") from None

    def _own_body(self) -> Body | None:
        """The body of the person of a result, where no other is asked for."""
        from halfphysics.formats.results.result_file import is_result
        from halfphysics.results.result import Result

        if self.person.given or not is_result(self.source):
            return None
        return Result.load(self.source).people[0].body

    @contextlib.contextmanager
    def _senders(self, body: Body) -> Iterator[list[Sender]]:
        from halfphysics.live import protocols
        from halfphysics.live.playback import ClientSender

        senders: list[Sender] = []
        try:
            for text in self.as_:
                if text.startswith(("ws:", "wss:")) or text == "ws":
                    senders.append(ClientSender(_url(text), PERSON, self.to))
                else:
                    senders.append(protocols.sender(text, person=PERSON, body=body))
            yield senders
        finally:
            for sender in senders:
                sender.stop()


def _url(text: str) -> str:
    """The address of a live session: "ws", "ws:8765", "ws:HOST:PORT" and addresses as they are."""
    from halfphysics.live.protocols.endpoint import endpoint

    if "://" in text:
        return text.removeprefix("ws:") if text.startswith("ws:ws") else text
    where = endpoint(text, 8765)
    return f"ws://{str(where).partition(':')[2]}"
