"""Short texts about a result."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.result import Result

_MOST = 8  # touched things listed per person


def summary(result: Result) -> str:
    """The work behind `Result.summary`."""
    seconds = (len(result) - 1) / result.fps
    lines = [f"{len(result)} frames at {result.fps:g} fps ({seconds:.2f} s)"]
    for index, person in enumerate(result.people):
        shift = person.motion.translation - person.reference.translation
        off = np.linalg.norm(shift, axis=1)
        lines.append(
            f"{person.name}: root off its path by {off.max():.3f} m at most, {off[-1]:.3f} m at "
            f"the end; {int(result.free_frames(index).sum())} free frames"
        )
        lines += _touches(result, index)
    for name, track in result.objects.items():
        path = np.linalg.norm(np.diff(track.position, axis=0), axis=1)
        speed = path.max() * result.fps if len(path) else 0.0
        lines.append(f"{name}: moved {path.sum():.3f} m, fastest {speed:.2f} m/s")
    smallest = result.clearance.min()
    if np.isfinite(smallest):
        where = int(np.argmin(result.clearance))
        kind = "penetration" if smallest < 0.0 else "distance"
        lines.append(
            f"smallest {kind} from what stands: {1000.0 * abs(smallest):.3f} mm (frame {where})"
        )
    lost = result.lost_time.sum()
    if lost > 0.0:
        lines.append(f"blocked steps were shortened by {lost:.4f} s in all")
    return "\n".join(lines)


def _touches(result: Result, person: int) -> list[str]:
    contacts = result.contacts[result.contacts.person == person]
    strength = np.linalg.norm(contacts.impulse, axis=1)
    lines = []
    others = np.unique(contacts.other)
    for other in others[:_MOST]:
        rows = contacts.other == other
        parts, first = np.unique(contacts.part[rows], return_index=True)
        named = [JOINT_NAMES[parts[k]] for k in np.argsort(first)]
        shown = ", ".join(named[:3]) + (f" and {len(named) - 3} more" if len(named) > 3 else "")
        count = len(np.unique(contacts.frame[rows]))
        lines.append(
            f"  touched {result.names[other]} in {count} frames with {shown}; hardest "
            f"{strength[rows].max():.2f} N s in a frame"
        )
    if len(others) > _MOST:
        lines.append(f"  and {len(others) - _MOST} more things")
    return lines
