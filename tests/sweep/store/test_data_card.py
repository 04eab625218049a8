"""The card of a data set: counts that add up, in any order, for ten million samples as for ten."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from halfphysics.errors import InputError
from halfphysics.sweep.make.card import CHECKS
from halfphysics.sweep.plan.plan import OF_SOFT, OF_SUPPORT, Inputs, Plan
from halfphysics.sweep.store.data_card import SPREADS, SUMMED, VALUES, DataCard, counted

VERSIONS = {"halfphysics": "0.1.0", "program": "ab" * 32, "mujoco": "3.3.0", "coacd": None}


def sample(number, **changes):
    """A card with the fields that the data card reads."""
    draw = random.Random(number)
    failed = number % 7 == 0
    card = {
        "input": f"clips/{number % 3}.npz",
        "body": "own",
        "scene": "room.yaml",
        "factors": {
            "objects.mass": [0.5, 1.0, 200.0][number % 3],
            "objects.friction": draw.uniform(0.1, 1.0),
            "settings.contact": ["skin", "parts"][number % 2],
            "scenario.table": bool(number % 2),
        },
        "success": not failed,
        "checks": {name: not (failed and name == "clear") for name in CHECKS},
        "versions": VERSIONS,
        **{name: draw.uniform(-0.01, 0.05) for name in SPREADS},
        **{name: draw.randrange(3) for name in SUMMED},
    }
    return {**card, **changes}


def failure(number, cause="object 'tea': mass: found 0.0, expected a number above 0"):
    return {"number": number, "input": "clips/0.npz", "factors": {"objects.mass": 0.5}} | {
        "cause": cause
    }


def made(numbers, per_batch=8):
    """Sums of batches of samples, some of which fail."""
    numbers = list(numbers)
    for first in range(0, len(numbers), per_batch):
        batch = numbers[first : first + per_batch]
        failed = [failure(n, f"clip {n}: damaged") for n in batch if n % 10 == 3]
        cards = [sample(n) for n in batch if n % 10 not in (3, 4)]
        yield counted(cards, failed, sum(n % 10 == 4 for n in batch))


def whole(sums):
    card = DataCard()
    for one in sums:
        card.add(json.loads(json.dumps(one, allow_nan=False)))
    return card


def bytes_of(card):
    return json.dumps([card.sums(), card.document(), card.markdown()], allow_nan=False)


def test_counts_are_those_of_the_cards():
    cards = [sample(n) for n in range(20)]
    found = whole([counted(cards, [failure(20)], skipped=4)]).document()
    assert (found["samples"], found["failed"], found["skipped"]) == (20, 1, 4)
    assert found["success"] == 17
    assert found["unsuccessful"] == {"whole": 0, "finite": 0, "clear": 3, "in_time": 0}
    for name in SUMMED:
        assert found["totals"][name] == sum(card[name] for card in cards)
        assert found["samples_with"][name] == sum(card[name] > 0 for card in cards)
    for name, unit in SPREADS.items():
        values = sorted(card[name] for card in cards)
        spread = found["spreads"][name]
        assert (spread["unit"], spread["number"]) == (unit, 20)
        assert (spread["least"], spread["most"]) == (values[0], values[-1])
        assert spread["mean"] == pytest.approx(sum(values) / 20, abs=1e-9)
        assert spread["p50"] == pytest.approx(values[9], abs=1e-3)
        assert sum(count for _, _, count in found["histograms"][name]) == 20
    assert found["versions"] == [VERSIONS]


def test_rates_of_every_value_of_a_factor():
    cards = [sample(n) for n in range(21)]
    found = whole([counted(cards, [failure(21)])]).document()["factors"]
    assert [row["value"] for row in found["objects.mass"]] == [0.5, 1.0, 200.0]
    for k, row in enumerate(found["objects.mass"]):
        own = [card for n, card in enumerate(cards) if n % 3 == k]
        assert row["samples"] == len(own) == 7
        assert row["success"] == sum(card["success"] for card in own)
        assert row["slipped"] == sum(card["slips"] > 0 for card in own)
        assert row["dropped"] == sum(card["drops"] > 0 for card in own)
        assert row["failed"] == (k == 0)
    assert [row["value"] for row in found["scenario.table"]] == [False, True]
    assert [row["value"] for row in found["settings.contact"]] == ["parts", "skin"]
    assert [row["value"] for row in found["input"]] == [f"clips/{k}.npz" for k in range(3)]
    assert found["input"][0]["failed"] == 1


def test_values_of_all_types_have_one_order():
    ordered = [None, False, True, -1.5, 0, 1, 2.5, "", "a"]
    for seed in range(3):
        values = random.Random(seed).sample(ordered, len(ordered))
        card = whole([counted([sample(k, factors={"x": v}) for k, v in enumerate(values)])])
        rows = card.document()["factors"]["x"]
        assert [json.dumps(row["value"]) for row in rows] == [json.dumps(v) for v in ordered]
        assert "| None | 1 |" in card.markdown()


def test_many_values_are_told_in_bins():
    found = whole(made(range(400))).document()["factors"]
    rows = found["objects.friction"]
    assert 25 <= len(rows) <= VALUES
    assert sum(row["samples"] for row in rows) == 320
    assert rows[0]["from"] <= 0.1 < rows[0]["to"]
    widths = {row["to"] - row["from"] for row in rows}
    assert widths == {1.0 / 32.0}
    names = whole([counted([sample(0, input=f"{n}.npz") for n in range(VALUES + 1)])])
    assert names.document()["factors"]["input"] is None


def test_the_order_and_the_cut_do_not_matter():
    expected = bytes_of(whole(made(range(400), 8)))
    for seed, per_batch in ((1, 8), (2, 1), (3, 50)):
        sums = list(made(range(400), per_batch))
        random.Random(seed).shuffle(sums)
        # Shards first, then the data set.
        shards = [whole(sums[first : first + 5]).sums() for first in range(0, len(sums), 5)]
        assert bytes_of(whole(shards)) == expected


def test_a_record_can_be_given_as_it_is():
    sums = counted([sample(1)])
    card = DataCard()
    card.add({"shard": 3, "sums": sums})
    assert card.sums() == sums


def test_counts_of_another_version_are_refused():
    for record in ({"version": 2, "numbers": {}}, {"shard": 1}, {"sums": None}):
        with pytest.raises(InputError, match="found counts of version"):
            DataCard().add(record)


def test_it_does_not_grow_with_the_number_of_samples():
    """Twenty times the samples, the same size but for digits."""
    sizes = [len(json.dumps(whole(made(range(count))).sums())) for count in (500, 10_000)]
    assert sizes[1] < 1.25 * sizes[0]


def test_failures_are_told_by_what_went_wrong():
    causes = [
        "/data/clips/12.npz: damaged (line 7)",
        "/data/clips/9.npz: damaged (line 12)",
        "object 'tea': mass: found 0.0, expected a number above 0",
        "object 'cup': mass: found -1.5e-3, expected a number above 0",
        "its process died",
    ]
    card = whole([counted([], [failure(n, cause) for n, cause in enumerate(causes)])])
    assert card.document()["failures"] == {
        "... damaged (line #)": 2,
        "its process died": 1,
        "object '...': mass: found #, expected a number above #": 1,
        "object '...': mass: found -#, expected a number above #": 1,
    }
    many = [failure(n, f"{chr(97 + n % 26)}{chr(97 + n // 26)}") for n in range(VALUES + 1)]
    crowded = whole([counted([], many)])
    assert crowded.document()["failures"] is None
    assert "failures.jsonl" in crowded.markdown()


def test_a_number_that_is_not_known_is_not_counted():
    found = whole([counted([sample(1, force_max=None), sample(2)])]).document()
    assert found["spreads"]["force_max"]["number"] == 1


def test_support_is_in_the_card_where_samples_have_it():
    with_support = whole([counted([sample(n, unsupported_percent=n) for n in range(5)])])
    its = with_support.document()["spreads"]["unsupported_percent"]
    assert (its["number"], its["least"], its["most"], its["unit"]) == (5, 0, 4, "%")
    assert "| unsupported_percent [%] | 5 |" in with_support.markdown()
    without = {name: None for name in OF_SUPPORT}
    page = whole([counted([sample(n, **without) for n in range(5)])]).markdown()
    assert not any(name in page for name in OF_SUPPORT)
    # Cards of a version of the program that did not have it.
    older = {name: value for name, value in sample(1).items() if name not in OF_SUPPORT}
    assert whole([counted([older])]).document()["samples"] == 1


def test_pressures_are_on_the_page_where_something_is_soft():
    soft = whole([counted([sample(n, pressure_max=1e3 * n) for n in range(1, 4)])])
    assert "| pressure_max [Pa] | 3 |" in soft.markdown()
    hard = whole([counted([sample(n, **dict.fromkeys(OF_SOFT, 0.0)) for n in range(3)])])
    assert not any(name in hard.markdown() for name in OF_SOFT)


def test_the_page_tells_it_to_a_person():
    plan = Plan(inputs=(Inputs(scenarios=("kick_ball",)),), seed=11, base=Path())
    card = DataCard(plan)
    for sums in made(range(400)):
        card.add(sums)
    text = card.markdown()
    document = card.document()
    assert document["seed"] == 11
    assert document["plan"] == plan.document()
    assert f"{document['success']:,} (" in text
    assert "halfphysics.sweep.read" in text
    assert "licences" in text
    assert "| clip #: damaged | 40 |" in text
    assert "### objects.friction" in text
    table = text.partition("### objects.friction")[2].partition("###")[0]
    rows = [line for line in table.splitlines() if line.startswith("| 0.")]
    assert 6 <= len(rows) <= 12  # merged bins
    assert sum(int(row.split("|")[2].replace(",", "")) for row in rows) == document["samples"]


def test_numbers_that_were_drawn_are_taken_together_on_the_page():
    """Few samples, each with a number of its own; a list of values stays a list."""
    cards = [sample(n, factors={"drawn": n / 40.0, "listed": n % 20}) for n in range(40)]
    text = whole([counted(cards * 6)]).markdown()
    drawn = text.partition("### drawn")[2].partition("###")[0]
    assert "| 0 to 0.075 | 24 |" in drawn
    assert len([line for line in drawn.splitlines() if " to " in line]) == 10
    listed = text.partition("### listed")[2].partition("###")[0]
    assert "| 7 | 12 |" in listed


def test_of_nothing_there_is_a_card_too():
    card = DataCard()
    assert card.document()["samples"] == 0
    assert card.document()["spreads"]["seconds"]["p50"] is None
    assert "Made with nothing yet" in card.markdown()
    assert "There is no sample." in card.markdown()
    assert "Every sample is a success" not in card.markdown()


def test_what_is_only_rounding_is_zero_on_the_page():
    text = whole([counted([sample(0, travel_max=7e-17), sample(1, travel_max=7e-17)])]).markdown()
    assert "| travel_max [m] | 2 | 0 | 0 |" in text
