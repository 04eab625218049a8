"""Other people's live protocols, both ways, one file each, by their names.

A module has `PORT` and a function `receiver`, `sender` or both. It is imported when it is used.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.live.incoming import Receiver, Sender
    from halfphysics.live.protocols.endpoint import Endpoint

#: Protocols that poses come in by -> who sends them. The modules of these names implement them.
RECEIVERS: Mapping[str, str] = MappingProxyType(
    {
        "vmc": "VMC 3.1: VSeeFace, SlimeVR, VirtualMotionCapture, Unity, Blender",
        "mocopi": "mocopi: Sony's app",
        "xsens": "Xsens MVN: its network streamer, quaternions",
        "rokoko": "Rokoko Studio: custom streaming, JSON version 3",
        "pico": "PICO headsets, by XRoboToolkit's SDK",
    }
)
#: Protocols that corrected poses go out by -> who receives them.
SENDERS: Mapping[str, str] = MappingProxyType(
    {
        "vmc": "VMC 3.1: Unity, Unreal, Blender, Godot, VSeeFace, Warudo",
        "mocopi": "what receives from mocopi's app",
        "xsens": "what receives from Xsens MVN",
        "rokoko": "what receives from Rokoko Studio",
        "sonic": "robots that SONIC drives (ZeroMQ; needs pyzmq)",
    }
)


def receiver(text: str, *, person: str, body: Body) -> Receiver:
    """A receiver by its name and where it listens: "vmc", "vmc:39539", "vmc:0.0.0.0:39539".

    ",calibrate=5" at the end: five seconds after the first pose the person stands in a T-pose, from
    which the sender's bones are known. Without it the sender's rest pose is as its protocol says.

    Args:
        text: PROTOCOL, PROTOCOL:PORT or PROTOCOL:HOST:PORT. Without a host it is this machine's
            loopback, which other machines do not reach.
        person: Name of the person whose poses come.
        body: The person's body: positions and proportions of the sender are fitted to it.

    Raises:
        InputError: An unknown protocol, or one that poses do not come in by; no such address.
    """
    where, _, rest = text.partition(",")
    calibrate = None
    if rest:
        name, _, seconds = rest.partition("=")
        if name != "calibrate":
            raise InputError(f"{text!r}: found {rest!r}, expected calibrate=SECONDS")
        try:
            calibrate = number(float(seconds), "calibrate", least=0.0, unit="s")
        except ValueError:
            raise InputError(f"{text!r}: expected calibrate=SECONDS, such as calibrate=5") from None
    module, endpoint = _module(where, RECEIVERS, "received")
    found: Receiver = module.receiver(endpoint, person, body, calibrate=calibrate)
    return found


def sender(text: str, *, person: str, body: Body) -> Sender:
    """A sender by its name and where it sends to: "vmc:127.0.0.1:39539"; see `receiver`.

    Raises:
        InputError: An unknown protocol, or one that poses do not go out by; no such address.
        MissingDependencyError: The protocol needs a package that is not installed.
    """
    module, endpoint = _module(text, SENDERS, "sent")
    found: Sender = module.sender(endpoint, person, body)
    return found


def endpoint_of(text: str) -> Endpoint:
    """Where "vmc:HOST:PORT" leads, with the protocol's own port where none is given."""
    return _module(text, {**RECEIVERS, **SENDERS}, "known")[1]


def check(listen: Sequence[str], forward: Sequence[str]) -> None:
    """That several people's protocols do not meet at one address; see `check_apart`.

    Args:
        listen: As for `receiver`, one for each person.
        forward: As for `sender`, likewise.

    Raises:
        InputError: They meet, or one is not known.
    """
    from halfphysics.live.protocols.endpoint import check_apart

    heard = [_module(text.partition(",")[0], RECEIVERS, "received")[1] for text in listen]
    sent = [_module(text, SENDERS, "sent")[1] for text in forward]
    check_apart(heard, [place for place in sent if place.protocol in RECEIVERS])


def _module(text: str, known: Mapping[str, str], done: str) -> tuple[Any, Endpoint]:
    from halfphysics.live.protocols.endpoint import endpoint

    name = text.partition(":")[0]
    if name not in known:
        hint = did_you_mean(name, known, otherwise=".")
        raise InputError(
            f"protocol {name!r} is not {done}{hint} Expected one of {', '.join(known)}"
        )
    module: Any = importlib.import_module(f"{__name__}.{name}")
    return module, endpoint(text, module.PORT)
