"""The driver of a sweep on a simulated cluster: it loses no variant, at a flat cost per variant."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from campaigns.sweep_driver import PARTS, main, measure
from halfphysics.errors import InputError
from halfphysics.sweep.plan.plan import Inputs, Outputs, Plan
from halfphysics.sweep.plan.values import spec
from halfphysics.sweep.store.store import Store
from support.sweeps.simulated_cluster import Cluster

CALM = Cluster(machines=3, cores=4, failing=0.0, killing=0.0, dying=0.0, straggling=0.0)


def plan_of(variants, shard=100, **changes):
    return Plan(
        inputs=(Inputs(scenarios=("kick_ball",)),),
        factors={"scenario.friction": spec({"uniform": [0.2, 1.0]})},
        samples=variants,
        outputs=Outputs(variants_per_shard=shard, batch=4),
        **changes,
    )


def test_calm_machines_do_all_of_it_and_are_busy(tmp_path):
    found = measure(plan_of(10_000), CALM, tmp_path)
    assert (found.variants, found.batches, found.shards) == (10_000, 2500, 100)
    assert (found.deaths, found.failures) == (0, 0)
    # A core has 833 variants of half a second: the average of their sum is known to 1.7 %.
    ideal = (10_000 * CALM.seconds + 100 * CALM.sealing) / 12
    assert found.makespan * found.utilisation == pytest.approx(ideal, rel=0.03)
    assert found.utilisation > 0.97
    assert len(found.parts) == PARTS
    lines = [json.loads(line) for line in (tmp_path / "manifest.jsonl").read_text().splitlines()]
    assert [line["first"] for line in lines] == list(range(0, 10_000, 100))
    assert sum(line["samples"] for line in lines) == 10_000
    assert all(Store(tmp_path, plan_of(10_000)).done(shard) for shard in range(100))


def test_the_same_seed_is_the_same_sweep():
    first, again, other = (
        measure(plan_of(1000), Cluster(machines=2, cores=4, seed=seed)) for seed in (1, 1, 2)
    )
    assert (first.makespan, first.tasks) == (again.makespan, again.tasks)
    assert first.makespan != other.makespan


def test_wild_machines_lose_nothing_but_what_fails(tmp_path):
    """Killing variants are found and named, whichever others die beside them."""
    wild = replace(CALM, failing=0.01, killing=0.002, dying=0.02, straggling=0.02)
    found = measure(plan_of(5000), wild, tmp_path)
    card = json.loads((tmp_path / "card.json").read_text())
    assert card["samples"] + card["failed"] == 5000
    assert found.failures == card["failed"]
    assert 20 < found.failures < 110  # 60 expected, standard deviation 8
    assert found.deaths > 2 * 5  # each killing one does so in a group, in its batch, and alone
    failures = (tmp_path / "failures.jsonl").read_text().splitlines()
    assert len({json.loads(line)["number"] for line in failures}) == found.failures


def test_conditions_of_the_plan_leave_variants_out(tmp_path):
    found = measure(plan_of(2000, keep=("scenario.friction < 0.6",)), CALM, tmp_path)
    card = json.loads((tmp_path / "card.json").read_text())
    assert card["samples"] + card["skipped"] == found.variants
    assert card["skipped"] == pytest.approx(1000, abs=100)  # standard deviation 22


def test_ten_times_the_sweep_is_ten_times_the_work():
    """For the driver's time and its memory; tasks of one batch of four are many."""
    cluster = Cluster(machines=20, cores=8, seconds=1.0)
    small, large = (measure(plan_of(variants, 1000), cluster) for variants in (10_000, 100_000))
    assert large.tasks > 9 * small.tasks
    # The small sweep's time includes the fixed costs; measured 8 to 10.
    assert sum(large.parts) < 15.0 * sum(small.parts)
    assert large.growth < 1.5  # measured 0.95 to 1.2
    assert large.manifest < 11 * small.manifest
    assert large.memory < small.memory + 30e6  # 90,000 more variants


def test_the_report_says_what_was_measured():
    text = str(measure(plan_of(1000), Cluster(machines=2, cores=2)))
    assert "2 machines of 2 cores" in text
    assert "1,000 variants, 250 batches, 10 shards" in text
    for line in ("driver", "memory", "written", "takes"):
        assert f"\n{line} " in text


def test_from_the_command_line(tmp_path, capsys, monkeypatch):
    """No variant is simulated, and no file remains beside the plan."""
    plan = tmp_path / "plan.yaml"
    plan.write_text("inputs: {scenarios: [kick_ball]}\nfactors: {objects.friction: [0.3, 0.6]}\n")
    arguments = ["sweep_driver", str(plan), "--machines", "3", "--cores", "5"]
    monkeypatch.setattr("sys.argv", arguments)
    main()
    assert "3 machines of 5 cores" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == [plan]


def test_what_cannot_be_is_said(tmp_path):
    with pytest.raises(InputError, match="machines: found 0, expected 1 or more"):
        Cluster(machines=0)
    with pytest.raises(InputError, match=r"dying: found 2.0, expected 0 to 1"):
        Cluster(machines=1, dying=2.0)
    with pytest.raises(InputError, match=r"seconds: found 0.0, expected more than 0"):
        Cluster(machines=1, seconds=0.0)
    (tmp_path / "a.txt").touch()
    with pytest.raises(InputError, match="found files in it, expected an empty folder"):
        measure(plan_of(10), CALM, tmp_path)
