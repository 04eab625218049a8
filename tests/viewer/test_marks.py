"""The marks of a time line: contacts by kind, and the events of the labels."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.viewer.contacts import KINDS
from halfphysics.viewer.marks import DROP, HOLD, SLIP, contact_rows, event_rows, rows
from support.results.handled import G, Handled
from support.results.small_result import FPS, FRAMES, small_result


def test_contacts_of_a_kind_are_marks_with_their_strongest_pairs():
    found = {row.label: row for row in contact_rows(small_result())}
    assert set(found) == {
        "contact with the scene",
        "contact with an object",
        "contact of objects",
    }
    # The foot is on the floor all the time; the shoulder joins in at frames 6 and 7.
    (floor,) = found["contact with the scene"].marks
    assert (floor.start, floor.end) == (0.0, (FRAMES - 1) / FPS)
    assert floor.text == "right foot – floor 600 N, right shoulder – wall 90 N"
    # A contact of frame 10 happens in (9, 10].
    (kick,) = found["contact with an object"].marks
    assert (kick.start, kick.end) == pytest.approx((9 / FPS, 10 / FPS))
    assert kick.text == "right foot – ball 30 N"
    assert found["contact with an object"].color == KINDS[1].color


def test_a_pause_of_more_than_a_tenth_of_a_second_parts_two_marks():
    result = SimpleNamespace(**vars(small_result()))
    kept = np.isin(result.contacts.frame, [0, 1, 4, 5, 11]) & (result.contacts.other == 0)
    table = vars(result.contacts)
    result.contacts = SimpleNamespace(**{name: column[kept] for name, column in table.items()})
    (row,) = contact_rows(result)
    spans = [(round(m.start * FPS), round(m.end * FPS)) for m in row.marks]
    # Frames 2 and 3 are within the pause of 0.1 s, frames 6 to 10 are not.
    assert spans == [(0, 5), (10, 11)]


def test_several_results_have_rows_with_their_names():
    result = small_result()
    labels = [row.label for row in rows([result, result], ["soft", "stiff"])]
    assert labels == [f"{name}, {row.label}" for name in ("soft", "stiff")
                      for row in contact_rows(result)]  # fmt: skip
    document = contact_rows(result)[0].document()
    assert document["color"] == "rgb(13,122,56)"
    assert document["marks"][0][:2] == [0.0, 0.5]


def test_holds_and_drops_are_marks_of_their_times():
    """A box is held for a second, falls 0.8 m in free fall, and lies on the floor."""
    fps, first, height = 30.0, 30, 0.8
    landed = first + math.ceil(math.sqrt(2.0 * height / G) * fps)
    since = np.maximum(np.arange(landed + 15) - first, 0) / fps
    box = np.tile([0.0, 0.0, 1.2], (len(since), 1))
    box[:, 2] -= 0.5 * G * since**2
    box[landed:, 2] = 1.2 - height
    case = Handled(fps, box)
    case.push(range(1, first + 1), 1.0, 5.0)
    case.rest(range(landed, len(since)))
    held, drop = event_rows(case.result())
    assert (held.label, held.color, drop.label, drop.color) == ("hold", HOLD, "drop", DROP)
    (mark,) = held.marks
    assert (mark.start, mark.end) == pytest.approx((0.0, first / fps))
    assert mark.text == "box in right wrist, dropped"
    (mark,) = drop.marks
    assert (mark.start, mark.end) == pytest.approx((first / fps, landed / fps))
    assert mark.text == f"box falls 0.80 m onto floor, {math.sqrt(2.0 * G * height):.1f} m/s"


def test_slips_are_marks_of_their_times():
    """A box that is held slides 6 cm along the palm at 12 cm/s, from 1 s on."""
    fps = 30.0
    time = np.arange(90) / fps
    box = np.tile([0.0, 0.0, 1.2], (len(time), 1))
    box[:, 2] -= 0.12 * np.clip(time - 1.0, 0.0, 0.5)
    case = Handled(fps, box)
    case.push(range(1, len(time)), 1.0, 5.0)
    found = {row.label: row for row in event_rows(case.result())}
    assert found["slip"].color == SLIP
    (mark,) = found["slip"].marks
    assert (mark.start, mark.end) == pytest.approx((1.0, 1.5), abs=1.5 / fps)
    assert mark.text == "box slips 6 cm in right wrist"


def test_a_result_without_objects_has_no_events():
    assert event_rows(small_result()) == []
