"""Nothing passes through: people thrown at obstacles, and real clips through furnished rooms.

Every committed substep is judged independently (`clear_judge`): the hulls of the skin, or the rigid
parts, are clear of all items, and on the side of the first pose. A sample runs always;
`HALFPHYSICS_CLEAR=all` runs the whole campaign (`k/n`: every n-th case from k on), which keeps its
rows in `HALFPHYSICS_CLEAR_LOG` (out/clear.jsonl) and continues where it was stopped.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from campaigns.clear import (
    all_cases,
    campaign,
    clips,
    held_back,
    not_clear,
    room_cases,
    run,
    summary,
    throw_cases,
)
from support.judges.person_hulls import CONTACTS
from support.paths import ROOT
from support.throws import OBSTACLES

pytest.importorskip("coal")

WANTED = os.environ.get("HALFPHYSICS_CLEAR", "")
LOG = Path(os.environ.get("HALFPHYSICS_CLEAR_LOG", ROOT / "out" / "clear.jsonl"))
#: Relative to the steps of all throws at up to 5 m/s and N >= 8.
SHORTENED = 0.01


#: Places in the list of clips, and their collision shape.
EVERY_CLIP = pytest.mark.parametrize(
    "clip_rows",
    [(k, contact) for k in range(10) for contact in CONTACTS],
    ids=lambda p: f"{p[0]}-{p[1]}",
    indirect=True,
)


@pytest.fixture(scope="module")
def rows_of(tmp_path_factory):
    """Rows of all these cases, or of a few quick ones; run once."""
    known = {}

    def rows_of(name, contact, cases, data, few):
        if (name, contact) not in known:
            known[name, contact] = _rows_of(name, contact, cases, data, few)
        return known[name, contact]

    def _rows_of(name, contact, cases, data, few):
        order = {case.id: i for i, case in enumerate(all_cases(data))}
        cases = sorted(cases, key=lambda c: order[c.id])
        if WANTED:
            k, n = (0, 1) if WANTED == "all" else map(int, WANTED.split("/"))
            LOG.parent.mkdir(parents=True, exist_ok=True)
            rows = campaign([c for c in cases if order[c.id] % n == k], data, LOG, contact)
            print(f"\n{name}, {contact}\n{summary(rows)}")
        else:
            log = tmp_path_factory.mktemp("clear") / "rows.jsonl"
            rows = campaign(few(cases), data, log, contact)
        assert rows
        return rows

    return rows_of


#: Steps that were shortened again and again, each 0.15 um deeper in a rod: 7 um in the end. The end
#: check lets a micrometre pass; how much of it they use changes with roundings: none, or 0.05 um.
CREPT = (
    "throw-tumbling-rods-20x-30fps-N1-l0-tau0.02",
    "throw-flailing-rods-10x-30fps-N1-l0-tau0.02",
    "throw-flailing-rods-1x-30fps-N1-l10-tau0.02",
)


@pytest.mark.parametrize("wanted", CREPT)
def test_overlaps_do_not_creep(wanted):
    row = run(next(case for case in throw_cases() if case.id == wanted))
    assert row["shortened"] > 0
    assert row["ok"]
    assert row["gap_mm"] > -1e-4


def complaints(rows, what):
    return "\n".join(f"{row['id']}: {text}" for row in rows for text in what(row))


@pytest.mark.slow
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("kind", OBSTACLES)
def test_nobody_is_thrown_through(rows_of, kind, contact):
    def few(cases):
        quick = [c for c in cases if c.speed >= 2.0 and c.fps * c.substeps <= 240.0]
        return quick[: 2 if kind == "rods" or contact == "parts" else 5]

    rows = rows_of(kind, contact, [c for c in throw_cases() if c.where == kind], None, few)
    assert sum(row["touched"] for row in rows) > 0
    assert not complaints(rows, not_clear), complaints(rows, not_clear)
    slow = [r for r in rows if r["substeps"] >= 8 and r["speed"] <= 5.0]
    steps = sum(r["steps"] for r in slow)
    assert sum(r["shortened"] for r in slow) <= SHORTENED * steps


@pytest.fixture
def clip_rows(rows_of, shared_data, request):
    place, contact = request.param
    names = list(clips(shared_data))
    if place >= len(names):
        pytest.skip(f"{len(names)} clips can be read")

    def few(cases):
        """One of each clip: at twice its speed, which may lose no time, or at four times."""
        speed = (2.0, 4.0)[(place + CONTACTS.index(contact)) % 2]
        return [c for c in cases if c.substeps * c.fps <= 240.0 and c.speed == speed][:1]

    cases = [c for c in room_cases(shared_data) if c.what == names[place]]
    return rows_of(names[place], contact, cases, shared_data, few)


@pytest.mark.slow
@EVERY_CLIP
def test_real_clips_go_through_nothing(clip_rows):
    assert sum(row["touched"] for row in clip_rows) > 0
    assert not complaints(clip_rows, not_clear), complaints(clip_rows, not_clear)


@EVERY_CLIP
def test_real_clips_lose_no_time(clip_rows):
    assert not complaints(clip_rows, held_back), complaints(clip_rows, held_back)
