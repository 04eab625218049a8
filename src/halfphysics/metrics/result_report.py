"""The text of `Result.summary`: a result in words and numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsError
from halfphysics.metrics.part_report import clearances
from halfphysics.metrics.standing import standing
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.results.hold_lines import hold_lines
from halfphysics.results.layer_pressure import carried_share, pressures
from halfphysics.results.result import SETTLE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from halfphysics.results.inside import Inside
    from halfphysics.results.layer_pressure import LayerPressure
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

#: Joints nearer than this to the reference are on it: rounding [m].
EXACT = 1e-9
#: An object that moved by less than this did not move [m, rad].
STILL, STILL_TURN = 1e-3, np.deg2rad(1.0)
#: Friction that misses Coulomb's law by more tolerances of the solver than this is reported.
UNSETTLED = 5.0
_LISTED = 5  # touched things, and objects, that are listed
_PARTS = 3  # parts that are named for each


def summary(result: Result, *, brief: bool = False) -> str:
    """The work behind `Result.summary`; `brief`: without how people stand, which takes seconds."""
    lines, pairs = [_head(result)], pressures(result)
    for index, person in enumerate(result.people):
        block = [
            *_following(result, index),
            *hold_lines(result, index),
            *([] if brief else standing(result, index)),
            *_touches(result, index),
            *_pressed(result, pairs, person.name, index),
            *_inside(result, result.inside[result.inside.person == index]),
        ]
        lines += [f"{person.name}:", *(f"  {line}" for line in block)]
    people = {person.name for person in result.people}
    for other in dict.fromkeys(p.other for p in pairs if p.other not in people):
        lines += [f"{other}: {line}" for line in _pressed(result, pairs, other)]
    lines += [*_objects(result), *_inside(result, result.inside[result.inside.person < 0])]
    lines += [*_breaches(result), *_nearest(result), _cost(result)]
    return "\n".join(lines)


def _head(result: Result) -> str:
    statics = len(result.names) - len(result.objects) - len(result.people)
    counted = [
        _count(len(result.people), "person", "people"),
        _count(statics, "static"),
        _count(len(result.objects), "object"),
    ]
    return (
        f"{len(result)} frames at {result.fps:g} fps ({(len(result) - 1) / result.fps:.2f} s), "
        + ", ".join(counted)
    )


def _following(result: Result, index: int) -> list[str]:
    """How exactly the motion was followed, and the largest deviation from what was recorded."""
    person = result.people[index]
    shift = np.linalg.norm(person.motion.translation - person.recorded.translation, axis=1)
    root = (
        f"root off its path by {_length(shift.max())} at most, in {_when(result, shift.argmax())}, "
        f"and {_length(shift[-1])} at the end"
    )
    try:
        local, everywhere = person.joint_errors(driven=True)
        adapted = person.recorded is not person.reference
        asked = person.joint_errors() if adapted else (local, everywhere)
    except HalfPhysicsError as error:
        return [f"joints not compared with the reference: {error}", root]
    free = result.free_frames(index)
    if everywhere.max() < EXACT:
        followed = (
            f"followed exactly: no joint farther than {_length(everywhere.max())} from where the "
            "motion has it, in any frame"
        )
        if not adapted:
            return [followed]
    elif not free.any():
        followed = "never free of contact"
    else:
        # A body that was stopped keeps an offset of the root, which is reported with the root.
        worst = local[free].max()
        how = "motion followed exactly" if worst < EXACT else "motion not followed exactly"
        followed = (
            f"free of contact (for {SETTLE:g} s) in {int(free.sum())} of {len(free)} frames: {how} "
            f"there, no joint off by more than {_length(worst)} as seen from the pelvis"
        )
    local, everywhere = asked
    frame, joint = np.unravel_index(everywhere.argmax(), everywhere.shape)
    return [
        followed,
        f"from the {'recorded motion' if adapted else 'reference'}: MPJPE "
        f"{_length(local.mean())}, MPJPE-g {_length(everywhere.mean())}; largest "
        f"{JOINT_NAMES[joint]} {_length(everywhere.max())} in {_when(result, frame)}",
        root,
    ]


def _touches(result: Result, index: int) -> list[str]:
    """The items that a person touched with an impulse, the hardest contact first."""
    contacts = result.contacts
    contacts = contacts[(contacts.person == index) & (contacts.strength > 0.0)]
    if not len(contacts):
        return ["touched nothing"]
    # By item and frame [N].
    forces = np.zeros((len(result.names), len(result)))
    # A contact with oneself has a row for each of its two parts.
    own = contacts.other == len(result.names) - len(result.people) + index
    share = np.where(own, 0.5, 1.0)
    np.add.at(forces, (contacts.other, contacts.frame), share * contacts.strength * result.fps)
    touched = np.flatnonzero(forces.any(axis=1))
    touched = touched[np.argsort(-forces[touched].max(axis=1), kind="stable")]
    lines = []
    for other in touched[:_LISTED]:
        force = forces[other]
        frames = np.flatnonzero(force)
        lines.append(
            f"touched {result.names[other]} in {_span(result, frames)} with "
            f"{_parts(contacts[contacts.other == other])}; {_newtons(force[frames].mean())} mean, "
            f"{_newtons(force.max())} peak in frame {force.argmax()}"
        )
    if len(touched) > _LISTED:
        rest = [result.names[other] for other in touched[_LISTED:]]
        lines.append(f"touched {_some(rest, _LISTED)} too, less hard")
    return lines


def _pressed(
    result: Result, pairs: Sequence[LayerPressure], name: str, person: int | None = None
) -> list[str]:
    """The soft things that a person or object pressed in, the hardest pressed first."""
    found = [p for p in pairs if p.other == name]
    lines = []
    for its in sorted(found, key=lambda p: -p.peak.max())[:_LISTED]:
        frame = int(its.peak.argmax())
        frames = np.flatnonzero(its.peak)
        lines.append(
            f"pressed on {its.layer} in {_span(result, frames)}: peak "
            f"{_kilopascals(its.peak[frame])} in frame {frame}, there "
            f"{_kilopascals(its.mean[frame])} mean on {1e4 * its.area[frame]:.0f} cm²"
        )
    if found and person is not None:
        try:
            share = carried_share(result, person, found)
        except HalfPhysicsError:  # the body is missing: its mass is not known
            return lines
        lines.append(
            f"soft things carried {100.0 * share.max():.0f} % of the weight at most, "
            f"{100.0 * share[-1]:.0f} % at the end"
        )
    return lines


def _kilopascals(pressure: float | np.floating) -> str:
    return f"{1e-3 * pressure:.3g} kPa"


def _parts(contacts: Contacts) -> str:
    """The parts of some contacts, those with the largest impulses first."""
    total = np.bincount(contacts.part, weights=contacts.strength)
    order = np.argsort(-total, kind="stable")[: np.count_nonzero(total)]
    return _some([JOINT_NAMES[part] for part in order], _PARTS)


def _inside(result: Result, inside: Inside) -> list[str]:
    """Overlaps at the start and when they ended; overlaps that began later."""
    if not len(inside):
        return []
    keys = np.stack([inside.person, inside.part, inside.subject, inside.other])
    _, pair = np.unique(keys, axis=1, return_inverse=True)
    pair = pair.reshape(-1)  # numpy 2.0 gave it another shape
    pairs = [inside[pair == k] for k in range(pair.max() + 1)]
    pairs.sort(key=lambda rows: -rows.depth.max())
    lines = []
    for what, late in (("initial overlaps", False), ("later overlaps", True)):
        words, ends = [], []
        for rows in pairs:
            if bool(rows.frame.min()) != late:
                continue
            end = rows[int(rows.frame.argmax())]
            ends.append(int(end.frame[0]) + 1)
            words.append(rows[int(rows.depth.argmax())].described(result.names)[0])
            words[-1] += (
                f", out by {_when(result, ends[-1])}"
                if ends[-1] < len(result)
                else f", still {_length(end.depth[0])} at the end"
            )
        if not words:
            continue
        lines.append(f"{what}: {_some(words, _PARTS, '; ')}")
        if len(words) > _PARTS:
            still = sum(end == len(result) for end in ends)
            lines.append(
                f"{still} of these {len(words)} still inside at the end"
                if still
                else f"all {len(words)} out by {_when(result, max(ends))}"
            )
    return lines


def _breaches(result: Result) -> list[str]:
    """Overlaps that should not be: none, or the deepest of each pair."""
    found = result.breaches
    if not len(found):
        return []
    keys = np.stack([found.person, found.part, found.subject, found.other])
    pairs = [found[(keys == key[:, None]).all(axis=0)] for key in np.unique(keys, axis=1).T]
    pairs.sort(key=lambda rows: -rows.depth.max())
    people = len(result.people)
    words = []
    for rows in pairs:
        deepest = rows[int(rows.depth.argmax())]
        words.append(
            deepest.described(result.names, people)[0] + f" at {_when(result, deepest.frame[0])}"
        )
    return [f"clear bodies were let inside: {_some(words, _PARTS, '; ')}"]


def _objects(result: Result) -> list[str]:
    moved: list[tuple[float, str]] = []
    still = []
    for name, track in result.objects.items():
        way = np.linalg.norm(track.position - track.position[0], axis=1)
        start = rot.conjugate(rot.normalize(track.quaternion[0]))
        turn = np.linalg.norm(rot.log(rot.multiply(start, rot.normalize(track.quaternion))), axis=1)
        if way.max() < STILL and turn.max() < STILL_TURN:
            still.append(name)
            continue
        steps = np.linalg.norm(np.diff(track.position, axis=0), axis=1)
        text = (
            f"{name}: moved {_length(way[-1])} from start to end ({_length(steps.sum())} of path),"
            f" turned {np.rad2deg(turn[-1]):.0f}°; fastest {steps.max() * result.fps:.2f} m/s "
            f"before {_when(result, steps.argmax() + 1)}"
        )
        moved.append((-float(way.max()), text))
    lines = [text for _, text in sorted(moved)]
    if len(lines) > _LISTED:
        lines[_LISTED:] = [f"{len(lines) - _LISTED} more objects moved, less far"]
    if still:
        lines.append(f"did not move (less than {_length(STILL)}, 1°): {_some(still, _LISTED)}")
    return lines


def _nearest(result: Result) -> list[str]:
    """The deepest penetration of statics, and the minimum distance in frames without any."""
    statics = len(result.names) - len(result.objects) - len(result.people)
    if not statics:
        return []
    shape = "rigid parts" if result.settings.contact == "parts" else "skin"
    clear = result.clearance >= 0.0
    inside = result.inside[(result.inside.person >= 0) & (result.inside.other < statics)]
    clear[inside.frame] = False
    lines = []
    if (result.clearance < 0.0).any():
        frame = int(result.clearance.argmin())
        part, item = _closest(result, frame)
        lines.append(
            f"deepest in static geometry ({shape}): {part}{_length(-result.clearance[frame])} in "
            f"{item}, in {_when(result, frame)}"
        )
    if not clear.any():
        return lines
    distance = np.where(clear, result.clearance, np.inf)
    frame = int(distance.argmin())
    when = "" if clear.all() else f", nobody inside: {int(clear.sum())} frames"
    if not np.isfinite(distance[frame]):
        reach = _length(result.settings.clearance_range)
        return [*lines, f"no static within {reach} of the body ({shape}{when}) at any frame"]
    part, item = _closest(result, frame)
    return [
        *lines,
        f"minimum distance to static geometry ({shape}{when}): {part}{_length(distance[frame])} "
        f"from {item}, in {_when(result, frame)}; clearance set to "
        f"{_length(result.settings.clearance)}",
    ]


def _closest(result: Result, frame: int) -> tuple[str, str]:
    """The part (a blank after it) and the static that a frame's clearance is between."""
    try:
        measured, nearest = clearances(result, slice(frame, frame + 1))
    except HalfPhysicsError:  # items of the scene are missing: only the number is known
        return "", "something"
    person, _, part = np.unravel_index(measured.argmin(), measured.shape)
    other = int(nearest[person, 0, part])
    if other < 0:
        return "", "something"
    whose = f"{result.people[person].name}'s " if len(result.people) > 1 else ""
    return f"{whose}{JOINT_NAMES[part]} ", result.names[other]


def _cost(result: Result) -> str:
    """Time lost by blocked steps, and the residuals of the contact solver."""
    lost = result.lost_time
    if lost.any():
        text = (
            f"lost {lost.sum():.2g} s where steps were blocked, in "
            f"{_count(int(np.count_nonzero(lost)), 'frame')}, most in "
            f"{_when(result, lost.argmax())}"
        )
    else:
        text = "no time lost"
    residual = result.diagnostics.get("residual")
    if residual is not None and residual.any():
        text += (
            f"; largest solver residual {_length(residual.max())}, in "
            f"{_when(result, residual.argmax())}"
        )
    unsettled = result.diagnostics.get("friction_tolerances")
    if unsettled is not None and (unsettled > UNSETTLED).any():
        missed = result.diagnostics["friction_residual"]
        text += (
            f"; largest friction residual {missed.max():.2g} m/s, in "
            f"{_when(result, missed.argmax())}, over {UNSETTLED:g} tolerances of the "
            f"solver in {_count(int(np.count_nonzero(unsettled > UNSETTLED)), 'frame')}"
        )
    return text


# -- words ---------------------------------------------------------------------------------


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def _when(result: Result, frame: int | np.integer) -> str:
    return f"frame {frame} ({frame / result.fps:.2f} s)"


def _span(result: Result, frames: NDArray[np.intp]) -> str:
    """Frames in words: their number and the time from the first to the last."""
    first, last = frames[0], frames[-1]
    if first == last:
        return _when(result, first)
    return (
        f"{len(frames)} frames from {first} to {last} ({first / result.fps:.2f} to "
        f"{last / result.fps:.2f} s)"
    )


def _length(metres: float | np.floating) -> str:
    """Metres from one on, millimetres below."""
    return f"{metres:.2f} m" if metres >= 0.9995 else f"{1000.0 * metres:.3g} mm"


def _newtons(force: float | np.floating) -> str:
    return f"{force:.0f} N" if force >= 100.0 else f"{force:.2g} N"


def _some(words: list[str], most: int, separator: str = ", ") -> str:
    """The first words, and the number of the others."""
    if len(words) <= most:
        return separator.join(words)
    return f"{separator.join(words[:most])} and {len(words) - most} more"
