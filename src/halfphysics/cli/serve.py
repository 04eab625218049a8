"""halfphysics serve: a scene in real time, for whoever moves now."""

from __future__ import annotations

import time
from collections.abc import Sequence as Several
from dataclasses import dataclass, field, make_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.base.suggestions import did_you_mean
from halfphysics.cli.options import BodyOptions, SceneOptions, check_output
from halfphysics.cli.parsing import Exit, parse
from halfphysics.errors import InputError
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.live.recording import Recorder
    from halfphysics.live.serve import LiveServer
    from halfphysics.live.session import Session
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics serve room.yaml
halfphysics serve shake_hands --out session.npz
halfphysics serve --object ball=sphere:0.11,mass=0.43,position=1:0:0.11 --people 2
halfphysics serve room.yaml --listen vmc:39539 --forward vmc:127.0.0.1:39540
halfphysics serve room.yaml --host 0.0.0.0 --token a-long-secret"""

#: Interval between two lines about latency [s], and how often it is looked whether it ended.
_EVERY, _LOOK = 10.0, 0.1

Repeated = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def read(prog: str, arguments: Several[str]) -> Command | Exit:
    """The command that the arguments describe; settings not given are the scenario's."""
    from halfphysics import scenarios

    command = parse(Command, prog, EXAMPLES, arguments)
    if isinstance(command, Exit) or command.where not in scenarios.names():
        return command
    own = scenarios.load(command.where).settings
    if own == Settings():
        return command
    kind = tyro.conf.OmitArgPrefixes[Settings]
    settings = ("settings", kind, field(default_factory=lambda: own))
    like = make_dataclass("Command", [settings], bases=(Command,), frozen=True, kw_only=True)
    return parse(like, prog, EXAMPLES, arguments)


@dataclass(frozen=True, kw_only=True)
class Command:
    """Serve a scene in real time: clients send poses and get corrected poses, objects and contacts.

    Prints the address. Ctrl-C ends it. The messages are described in docs/live.md.
    """

    where: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="SCENE|SCENARIO")] = (
        None
    )
    """Scene file, or a built-in scenario (halfphysics scenario --list): its scene, its people
    and their bodies where its motion begins."""
    people: int | None = None
    """Number of people; those of the scenario, or 1."""
    fps: float = 90.0
    """Steps per second: at least the rate of the poses."""
    port: int = 8765
    """Port to listen on; where it is in use, the next one that is free; 0: any."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0: other machines can connect, and need the token."""
    token: str | None = None
    """What clients must give; beyond this machine a new one is made if none is given."""
    origin: Annotated[Repeated, tyro.conf.arg(metavar="ORIGIN")] = ()
    """Web pages of other servers that may connect, such as http://localhost:5173."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="FILE")] = None
    """Result file (.npz) to record the session in; docs/live.md says how it survives a crash."""
    listen: Annotated[Repeated, tyro.conf.arg(metavar="PROTOCOL:PORT")] = ()
    """Another way in for poses, such as vmc:39539; once for each person."""
    forward: Annotated[Repeated, tyro.conf.arg(metavar="PROTOCOL:HOST:PORT")] = ()
    """Another way out for corrected poses, such as vmc:127.0.0.1:39540; once for each person."""
    for_: Annotated[float | None, tyro.conf.arg(name="for", metavar="SECONDS")] = None
    """End after this time [s]."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    settings: tyro.conf.OmitArgPrefixes[Settings] = field(default_factory=Settings)

    def run(self) -> None:
        """Serve until Ctrl-C."""
        from halfphysics.live.interpreter import quick_answers, steady_memory
        from halfphysics.live.serve import serve

        if self.people is not None and self.people < 1:
            raise InputError(f"--people: found {self.people}, expected at least 1")
        if self.for_ is not None and not self.for_ > 0.0:
            raise InputError(f"--for: found {self.for_:g}, expected a time above 0 [s]")
        if self.out is not None:
            check_output(self.out, self._file(), self.scene.scene, self.person.body)
        steady_memory()
        scene, sequence = self._place()
        live = serve(
            scene,
            body=self._bodies(sequence),
            start=None if sequence is None else [motion[0] for motion in sequence.motions],
            settings=self.settings,
            fps=self.fps,
            host=self.host,
            port=self.port,
            token=self.token,
            origins=self.origin,
            record=self.out,
            listen=self.listen,
            forward=self.forward,
        )
        try:
            with live, quick_answers():
                if self.port not in (0, live.server.port):
                    print(f"port {self.port} is in use, taking {live.server.port}")
                people = ", ".join(live.session.people)
                print(f"a live session of {people} at {live.url}", flush=True)
                self._wait(live)
        finally:  # also after Ctrl-C
            if live.recorder is not None:
                print(_outcome(live.recorder), flush=True)

    def _file(self) -> Path | None:
        """The scene file that is served; None: a scenario, or what the options describe."""
        from halfphysics import scenarios

        return None if self.where in (None, *scenarios.names()) else Path(str(self.where))

    def _place(self) -> tuple[Scene, Sequence | None]:
        """The scene, and the scenario that it is of."""
        from dataclasses import replace

        from halfphysics import scenarios

        if self.where is None:
            return self.scene.load(), None
        if self.where in scenarios.names():
            sequence = scenarios.load(self.where)
            return self.scene.load(sequence.scene), sequence
        if self.scene.scene is not None:
            raise InputError("serve: found two scenes. Leave out --scene")
        path = Path(self.where)
        if not path.suffix and not path.exists():
            hint = did_you_mean(self.where, scenarios.names(), otherwise=".")
            raise InputError(
                f"serve: found {self.where!r}, which is no scene file and no scenario{hint} "
                f"Scenarios: {', '.join(scenarios.names())}"
            )
        return replace(self.scene, scene=path).load(), None

    def _bodies(self, sequence: Sequence | None) -> list[Body]:
        """Everybody's body: of those of a scenario their own, if no other is asked for."""
        own = () if sequence is None else zip(sequence.bodies, sequence.motions, strict=True)
        bodies = [self.person.instead_of(body, motion) for body, motion in own]
        count = self.people or len(bodies) or 1
        more = count - len(bodies)
        return [*bodies[:count], *([self._body()] * more if more > 0 else ())]

    def _body(self) -> Body:
        """The body of somebody without a motion."""
        from halfphysics.body.body import Body

        if self.person.body is None:
            return Body.default(stature=self.person.stature, mass=self.person.mass)
        if self.person.stature is not None:
            raise InputError("--stature is for the default body. Leave out --stature or --body")
        return Body.load(self.person.body, mass=self.person.mass)

    def _wait(self, live: LiveServer) -> None:
        begun = said = time.monotonic()
        try:
            while live.running:
                time.sleep(_LOOK)
                now = time.monotonic()
                if self.for_ is not None and now - begun >= self.for_:
                    return
                if now - said >= _EVERY:
                    print(_figures(live), flush=True)
                    said = now
        finally:
            print(_figures(live), flush=True)


def _outcome(recorder: Recorder) -> str:
    """What became of a recording in one line."""
    if recorder.written is None:
        return f"nothing to record: no frame was made, {recorder.path} is not written"
    return f"written: {recorder.written}"


def _figures(live: LiveServer) -> str:
    """Clients, latency, drops, and what protocols did not understand, in one line."""
    from halfphysics.live.protocols.udp import UdpReceiver

    counts, found = live.session.mailbox.counts, live.latency.percentiles(50.0, 99.0, 100.0)
    clients = live.server.clients
    parts = [f"{live.session.frames} frames", f"{clients} client{'' if clients == 1 else 's'}"]
    if found is not None:
        parts.append(
            "pose to step "
            + ", ".join(
                f"{name} {1000.0 * value:.2f} ms"
                for name, value in zip(("p50", "p99", "worst"), found, strict=True)
            )
        )
    parts.append(f"{counts.dropped} poses dropped")
    if live.session.clock.missed:
        parts.append(f"{live.session.clock.missed} steps missed")
    if live.session.trouble:
        parts.append(live.session.trouble)
    parts += _fast(live.session)
    for receiver in live.receivers:
        if isinstance(receiver, UdpReceiver) and receiver.trouble:
            parts.append(f"{receiver.endpoint}: {receiver.trouble}")
    return "; ".join(parts)


def _fast(session: Session) -> list[str]:
    """Who is sent faster than the physics steps: some poses pass unseen."""
    from halfphysics.live.clock import shortest

    dt, said = session.simulator.dt, []
    for name in session.people:
        interval = session.mailbox.interval(name)
        if session.mailbox.silence(name) < _EVERY and 0.0 < interval < shortest(dt):
            rate = 1.0 / interval
            said.append(f"{name} is sent at {rate:.0f} Hz: --fps {rate:.0f} steps with every pose")
    return said
