"""Summaries of parts of a result and of a scene, from what is at hand: nothing is measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted, numbers
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Inside
from halfphysics.results.moment import Figure, Moment
from halfphysics.results.result import PersonResult
from halfphysics.results.table import Table
from halfphysics.scene.items import Object, Static
from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Lines about single things: more are counted.
MOST = 12
#: Width and height of the bars of a table [pixels], and their colour.
_WIDTH, _HEIGHT, _COLOR = 360, 90, "#3d7dca"
_MOST_BARS = 180


def person_lines(person: PersonResult) -> list[str]:
    """What a person did and met."""
    motion, fps = person.motion, person.motion.fps
    off = 1000.0 * np.linalg.norm(motion.translation - person.recorded.translation, axis=1)
    lines = [
        f"{motion.duration:.2f} s; root off its path by {off.max():.3g} mm at most, in frame "
        f"{off.argmax()}, and {off[-1]:.3g} mm at the end"
    ]
    waited = len(motion) / fps - 1.0 / fps - float(np.asarray(person.clock)[-1])
    if waited > 0.5 / fps:
        lines.append(f"waited {waited:.2f} s, blocked")
    if person.torque is not None:
        size = np.linalg.norm(person.torque[:, 1:], axis=2)
        if size.size and size.max() > 0.0:
            frame, joint = np.unravel_index(size.argmax(), size.shape)
            name = JOINT_NAMES[int(joint) + 1]
            lines.append(f"largest torque {size.max():.3g} N m, in {name}, frame {frame}")
    around = person.surroundings
    if around is not None and around.contacts is not None:
        own = around.contacts[around.contacts.person == around.person]
        lines += _touched(own, around.names, fps) or ["touches nothing"]
    return lines


def _touched(contacts: Contacts, names: tuple[str, ...], fps: float) -> list[str]:
    """What contacts touch, the hardest first."""
    found = []
    for other in np.unique(contacts.other):
        rows = contacts[contacts.other == other]
        parts = [JOINT_NAMES[part] for part in np.unique(rows.part)]
        more = f" and {len(parts) - 3} more" if len(parts) > 3 else ""
        force = float(rows.strength.max()) * fps
        frames = counted(len(np.unique(rows.frame)), "frame")
        with_what = ", ".join(parts[:3]) + more
        line = f"touches {names[other]} in {frames} with {with_what}; up to {force:.0f} N"
        found.append((-force, line))
    return _few([line for _, line in sorted(found)], "thing")


def contact_lines(contacts: Contacts) -> list[str]:
    """Who touches what, the hardest first; nothing of contacts of no result."""
    naming = contacts.naming
    if naming is None:
        return []
    first = len(naming.names) - naming.people
    own = np.where(contacts.person >= 0, first + contacts.person, contacts.subject)
    found = []
    for one, other in np.unique(np.stack([own, contacts.other]), axis=1).T:
        rows = contacts[(own == one) & (contacts.other == other)]
        force = float(rows.strength.max()) * naming.fps
        frames = counted(len(np.unique(rows.frame)), "frame")
        pair = f"{naming.names[one]} on {naming.names[other]}"
        found.append((-force, f"{pair}: {frames}, up to {force:.0f} N"))
    return _few([line for _, line in sorted(found)], "pair")


def scene_lines(scene: Scene) -> list[str]:
    """The items of a scene, one a line."""
    lines = [f"{name}: static {item.shape!r}{_soft(item)}" for name, item in scene.statics.items()]
    for name, item in scene.objects.items():
        lines.append(f"{name}: {_object(item)} at {numbers(item.position)} m")
    for name, jointed in scene.articulated.items():
        links = ", ".join(link.name for link in jointed.links)
        lines.append(f"{name}: articulated, links {links}")
    gravity = scene.gravity
    return [*_few(lines, "item"), f"gravity {numbers(gravity)} m/s^2"]


def _object(item: Object) -> str:
    kind = "kinematic" if np.isinf(item.mass) else f"{item.mass:.3g} kg,"
    return f"{kind} {item.true_shape!r}{_soft(item)}"


def _soft(item: Static | Object) -> str:
    """The layer of an item in words; nothing where it is hard."""
    if item.soft is None:
        return ""
    return f", soft for {1e3 * item.soft.thickness:.0f} mm"


def _few(lines: list[str], what: str) -> list[str]:
    if len(lines) <= MOST:
        return lines
    return [*lines[:MOST], f"and {counted(len(lines) - MOST, what)} more"]


def alone(person: PersonResult) -> Moment:
    """A person with the scene and its objects, without the other people.

    Raises:
        InputError: The person is of no result.
    """
    around = person.surroundings
    if around is None:
        raise InputError(f"person {person.name!r} is of no result: there is no scene to show")
    figure = Figure(person.body, person.motion)
    return Moment(people=(figure,), scene=around.scene, objects=around.tracks)


def strip(table: Table) -> str:
    """Bars of a table over frames as SVG: the impulses of contacts, the depths of overlaps."""
    if not len(table) or not isinstance(table, Contacts | Inside):
        return ""
    if isinstance(table, Contacts):
        values, label = _by_frame(table.frame, table.strength, sums=True), "impulse [N s]"
    else:
        values, label = _by_frame(table.frame, 1000.0 * table.depth, sums=False), "depth [mm]"
    first = int(table.frame.min())
    return _svg(values, f"{label}, frames {first} to {first + len(values) - 1}")


def _by_frame(frame: NDArray[np.int64], values: Array, *, sums: bool) -> Array:
    """Sum or largest of values in every frame, from the first frame to the last."""
    out = np.zeros(int(np.ptp(frame)) + 1)
    (np.add if sums else np.maximum).at(out, frame - frame.min(), values)
    return out


def _svg(values: Array, label: str) -> str:
    """Bars of values >= 0; of many frames the largest of a few are one bar."""
    wide = -(-len(values) // _MOST_BARS)
    shown = [float(values[k : k + wide].max()) for k in range(0, len(values), wide)]
    top = max(shown) or 1.0
    step = _WIDTH / len(shown)
    bars = "".join(_bar(k * step, step, _HEIGHT * value / top) for k, value in enumerate(shown))
    text = f"{label}; highest {top:.3g}"
    return (
        f'<svg role="img" width="{_WIDTH}" height="{_HEIGHT + 18}" '
        f'viewBox="0 0 {_WIDTH} {_HEIGHT + 18}"><title>{text}</title>'
        f'<g fill="{_COLOR}">{bars}</g>'
        f'<text x="0" y="{_HEIGHT + 14}" font-size="11" fill="currentColor">{text}</text></svg>'
    )


def _bar(left: float, width: float, height: float) -> str:
    if height <= 0.0:
        return ""
    top = _HEIGHT - height
    return f'<rect x="{left:.2f}" y="{top:.2f}" width="{0.9 * width:.2f}" height="{height:.2f}"/>'
