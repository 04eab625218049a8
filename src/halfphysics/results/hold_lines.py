"""Holds in words, for the summary and the page: forces, and what became of the thing."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from halfphysics.results.held import HeldReport

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: A thing that is recorded to rise by more than this [m] is to be lifted.
RISES = 0.05
#: It was lifted where it rose by this share of its record, and not at all below the second.
LIFTED, NOT_LIFTED = 0.9, 0.5
#: A thing that was farther than this from its record during the hold, or turned by more, was not
#: carried as recorded [m], [deg].
CARRIED, TURNED = 0.10, 15.0
#: Hands that touch a thing for longer than this after its hold let go late [s].
LATE = 0.1
_ROUNDING = 1e-9
#: What a part that holds is called, by the joint that stands for it.
_WORDS = {"wrist": "hand", "ankle": "foot", "pelvis": "seat"}


def hold_lines(result: Result, index: int) -> list[str]:
    """One line for every hold of a person of a result, in the order of time."""
    own = [report for report in result.holds if report.person == result.people[index].name]
    each = groupby(own, key=lambda report: (report.object, report.start, report.end))
    return [line_of(list(hands)) for _, hands in each]


def line_of(hands: Sequence[HeldReport]) -> str:
    """One hold in words: who, when, forces, and how the thing fared.

    Args:
        hands: The reports of all hands of the hold.
    """
    one = hands[0]
    return (
        f"holds {one.object} with {_parts(hands)}, {one.start:.1f} to {one.end:.1f} s: "
        f"{_forces(hands)}; {'; '.join(_outcome(one))}"
    )


def _parts(hands: Sequence[HeldReport]) -> str:
    """The parts in words: "left and right hand", "right foot", "the seat", or joints by name."""
    ends = {hand.part.split("_")[-1] for hand in hands}
    word = _WORDS.get(ends.pop()) if len(ends) == 1 else None
    if word is None:
        return " and ".join(hand.part for hand in hands)
    sides = " and ".join(hand.part.split("_")[0] for hand in hands if "_" in hand.part)
    return f"{sides or 'the'} {word}"


def _forces(hands: Sequence[HeldReport]) -> str:
    if not any(hand.touched for hand in hands):
        return "never touched"
    reached = " and ".join(f"{hand.reached:.0f}" for hand in hands)
    margin = min(hand.margin for hand in hands)
    asked = f"{hands[0].asked:.0f} N required, " if hands[0].asked else ""
    words = f"{asked}{reached} N reached, friction margin {margin:.1f}"
    least = min(hand.touched for hand in hands)
    return words if least > 0.95 else f"{words}, touched {100.0 * least:.0f} % of the time"


def _outcome(hold: HeldReport) -> list[str]:
    """What became of the thing, what failed first."""
    words = []
    if hold.recorded_rise > RISES:
        share = hold.rise / hold.recorded_rise
        how = (
            "lifted" if share >= LIFTED else "lifted only" if share >= NOT_LIFTED else "not lifted:"
        )
        words.append(f"{how} {hold.rise:.2f} of {hold.recorded_rise:.2f} m")
    if hold.lost is not None and hold.lost > hold.start:
        words.append(f"lost at {hold.lost:.1f} s")
    if hold.late > LATE + _ROUNDING:
        words.append(f"let go {hold.late:.1f} s late")
    carried = hold.away <= CARRIED and hold.turned_deg <= TURNED
    words.append(
        f"{'' if carried else 'not carried as recorded: '}up to {100.0 * hold.away:.0f} cm and "
        f"{hold.turned_deg:.0f}° off its record, {100.0 * hold.end_away:.0f} cm at the end"
    )
    return words
