"""From a number to a variant: every combination once, in order, at once, without a list."""

from __future__ import annotations

import itertools
import pickle
import time
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.errors import FileError, InputError
from halfphysics.sweep import Plan, Variants, describe
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.inputs import InputList, Inputs

FILES = [f"file\tclips/{k}.npz\t0" for k in range(3)]


def a_plan(**changes: object) -> Plan:
    return Plan(**{"inputs": Inputs(files="clips/*.npz"), **changes})


def wide() -> Plan:
    """Inputs x 2 bodies x 2 scenes x 2 x 3 x 2 draws."""
    return a_plan(
        bodies=(BodyChoice(), BodyChoice(stature=1.6)),
        scenes=(SceneChoice(), SceneChoice(file="room.yaml")),
        factors={
            "objects.mass": [1, 5],
            "objects.friction": {"uniform": [0.2, 1.2]},
            "motion.yaw": {"from": -30, "to": 30, "count": 3},
            "body.betas.0": {"normal": [0, 1]},
        },
        samples=2,
        seed=7,
        base=Path("/data"),
    )


def test_every_combination_once_the_input_slowest() -> None:
    variants = Variants(wide(), FILES)
    assert len(variants) == 3 * 2 * 2 * 2 * 3 * 2 == 144
    found = [
        (
            v.input.name,
            v.body.name,
            v.scene.name,
            v.factors["objects.mass"],
            v.factors["motion.yaw"],
        )
        for v in variants
    ]
    names = [f"clips/{k}.npz" for k in range(3)]
    combinations = itertools.product(
        names, ["own", "stature=1.6"], ["own", "room.yaml"], [1, 5], [-30, 0, 30]
    )
    assert found == [each for each in combinations for _ in range(2)]
    assert [v.number for v in variants] == list(range(144))
    drawn = {v.factors["objects.friction"] for v in variants}
    assert len(drawn) == 144
    assert all(0.2 < value < 1.2 for value in drawn)


def test_a_variant_is_the_same_alone_and_anywhere() -> None:
    one, other = Variants(wide(), FILES), Variants(wide(), FILES)
    forward = list(one)
    assert [other[k] for k in reversed(range(144))] == forward[::-1]
    assert pickle.loads(pickle.dumps(other[77])) == forward[77]
    assert pickle.loads(pickle.dumps(other))[77] == forward[77]
    assert one[-1] == forward[143]
    assert one[5:8] == forward[5:8]
    with pytest.raises(IndexError, match="variant 144 of 144"):
        one[144]
    # In the plan's order, for drawn and listed values.
    assert list(forward[3].factors) == list(wide().factors)


def test_variants_are_what_they_were() -> None:
    """Frozen: a data set can be made again by any later version."""
    variant = Variants(wide(), FILES)[90]
    assert variant.key == "000000090"
    assert variant.input.path == Path("/data/clips/1.npz")
    assert variant.scene.path == Path("/data/room.yaml")
    assert dict(variant.factors) == FROZEN
    assert variant.values() == {
        **FROZEN,
        "input": "clips/1.npz",
        "body": "stature=1.6",
        "scene": "room.yaml",
    }


FROZEN: dict[str, object] = {
    "objects.mass": 5,
    "objects.friction": 0.3130661732908621,
    "motion.yaw": -30,
    "body.betas.0": 0.360046184396106,
}


def test_another_distribution_changes_no_draw_of_the_others() -> None:
    plan = wide()
    more = a_plan(
        bodies=plan.bodies,
        scenes=plan.scenes,
        factors={"objects.scale": {"uniform": [0.9, 1.1]}, **plan.factors},
        samples=2,
        seed=7,
    )
    for before, after in zip(Variants(plan, FILES), Variants(more, FILES), strict=True):
        assert {k: after.factors[k] for k in before.factors} == before.factors
    reseeded = Variants(a_plan(factors=plan.factors, seed=8), FILES)[0]
    assert (
        reseeded.factors["objects.friction"] != Variants(plan, FILES)[0].factors["objects.friction"]
    )


@settings(max_examples=100)
@given(st.lists(st.integers(1, 5), max_size=5), st.integers(1, 4), st.data())
def test_numbers_count_in_mixed_radix(sizes: list[int], inputs: int, data: st.DataObject) -> None:
    factors = {f"body.betas.{k}": list(range(size)) for k, size in enumerate(sizes)}
    variants = Variants(a_plan(factors=factors), FILES[:1] * inputs)
    number = data.draw(st.integers(0, len(variants) - 1))
    rest = 0
    for name, size in zip(factors, sizes, strict=True):
        rest = rest * size + variants[number].factors[name]
    assert number % max(1, len(variants) // inputs) == rest


def test_conditions_choose_variants() -> None:
    plan = a_plan(
        factors={"objects.mass": [1, 5], "motion.yaw": {"uniform": [0, 90]}},
        samples=10,
        keep=["objects.mass < 2 or motion.yaw > 45", "input != 'clips/2.npz'"],
    )
    variants = Variants(plan, FILES)
    kept = [v for v in variants if variants.keeps(v)]
    assert 0 < len(kept) < len(variants)
    for variant in variants:
        mass, yaw = variant.factors.values()
        expected = (mass == 1 or yaw > 45) and variant.input.name != "clips/2.npz"
        assert variants.keeps(variant) is expected
    free = Variants(a_plan(), FILES)
    assert free.keeps(free[0])


def test_a_sample_is_spread_and_always_the_same() -> None:
    small = Variants(a_plan(), FILES)
    assert small.sample(10) == [0, 1, 2]
    plan = a_plan(factors={"body.betas.0": {"from": 0, "to": 1, "count": 100_000}})
    sample = Variants(plan, FILES).sample(1000)
    assert sample == Variants(plan, FILES).sample(1000)
    assert len(set(sample)) == 1000
    assert sample == sorted(sample)
    # A thousand even draws: none of ten parts has fewer than 60 or more than 140 (4 sigma).
    parts = [sum(k * 30_000 <= s < (k + 1) * 30_000 for s in sample) for k in range(10)]
    assert all(60 <= part <= 140 for part in parts)


def test_too_many_to_number() -> None:
    factors = {f"body.betas.{k}": {"from": 0, "to": 1, "count": 100_000} for k in range(4)}
    with pytest.raises(InputError, match=r"found 3.* variants, expected at most"):
        Variants(a_plan(factors=factors), FILES)
    # Nine digits, or keys would not sort as numbers do.
    million = {f"body.betas.{k}": {"from": 0, "to": 1, "count": 1000} for k in range(3)}
    each = Variants(a_plan(factors=million), FILES[:1])
    assert each[len(each) - 1].key == "999999999"
    with pytest.raises(InputError, match=r"found 2,000,000,000 variants, .* 1,000,000,000;"):
        Variants(a_plan(factors=million), FILES[:2])
    with pytest.raises(InputError, match="inputs: found none"):
        Variants(a_plan(), [])


@pytest.fixture(scope="module")
def million(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A list of a million inputs."""
    path = tmp_path_factory.mktemp("inputs") / "inputs.txt"
    with path.open("w", encoding="utf-8") as handle:
        handle.writelines(f"file\tclips/{k // 1000:03d}/{k:06d}.npz\t0\n" for k in range(1_000_000))
    return path


def test_ten_million_variants_of_a_million_inputs_need_no_list(million: Path) -> None:
    plan = a_plan(
        bodies=(BodyChoice(), BodyChoice(stature=1.6)),
        factors={
            "objects.mass": [1, 2, 5, 10, 20],
            "objects.friction": {"uniform": [0.2, 1.2]},
            "body.betas.0": {"normal": [0, 1], "within": [-2, 2]},
        },
        keep="objects.friction > 0.5",
    )
    tracemalloc.start()
    variants = Variants(plan, InputList(million))
    assert len(variants) == 10_000_000
    described = describe(plan, variants)
    for number in range(0, 10_000_000, 9_973):
        assert variants[number].number == number
    assert variants[9_999_999].input.name == "clips/999/999999.npz"
    current, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # The offsets are 8 MB; twice that while they are put together.
    assert current < 9e6
    assert peak < 20e6
    assert "inputs  1,000,000: clips/000/000000.npz" in described
    assert "10,000,000" in described
    assert "about 70" in described


def test_a_variant_takes_microseconds(million: Path) -> None:
    variants = Variants(wide(), InputList(million))
    numbers = range(0, len(variants), len(variants) // 1000)
    best = min(_seconds(variants, numbers) for _ in range(20))
    # 14 µs where this was written; the bound leaves room for machines that are slower and busy.
    assert best / len(numbers) < 100e-6


def _seconds(variants: Variants, numbers: range) -> float:
    start = time.process_time()
    for number in numbers:
        variants[number]
    return time.process_time() - start


def test_lists_of_inputs(tmp_path: Path) -> None:
    path = tmp_path / "inputs.txt"
    lines = ["scenario\tkick_ball\t0", "file\tä ö.npz\t1", "", "file\tb\t1"]
    path.write_bytes("\n".join(lines).encode())
    inputs = InputList(path)
    assert list(inputs) == lines
    assert inputs[-1] == lines[-1]
    assert inputs[1:3] == lines[1:3]
    assert list(pickle.loads(pickle.dumps(inputs))) == lines
    with pytest.raises(IndexError):
        inputs[4]
    path.write_bytes("\n".join([*lines, ""]).encode())
    assert list(InputList(path)) == lines
    empty = tmp_path / "empty.txt"
    empty.touch()
    with pytest.raises(FileError, match="found no lines"):
        InputList(empty)
    with pytest.raises(FileError, match="cannot be read"):
        InputList(tmp_path / "none.txt")


@pytest.mark.parametrize("line", ["", "clip\ta.npz", "file\t", "file\ta\t7", "file\ta\tx"])
def test_lines_that_are_none_of_the_plan(line: str) -> None:
    with pytest.raises(FileError, match="inputs: found the line"):
        Variants(a_plan(), [line])[0]


def test_what_a_sweep_will_do(tmp_path: Path) -> None:
    plan = a_plan(
        bodies=(BodyChoice(), BodyChoice(stature=1.6)),
        factors={
            "objects.mass": [1, 2.5],
            "settings.clearance": {"from": 0.001, "to": 0.01, "count": 3, "scale": "log"},
            "objects.scale": {"choice": [0.9, 1], "weights": [1, 2]},
            "body.betas.0": {"normal": [0, 1], "within": [-2, 2]},
        },
        samples=5,
        keep="objects.mass < 2",
        settings={"stiffness": 0.5},
        base=tmp_path,
    )
    text = describe(plan, Variants(plan, FILES))
    assert text.splitlines() == [
        "inputs  3: clips/0.npz, clips/1.npz, clips/2.npz",
        "bodies  2: the input's, or the default body; stature=1.6",
        "scenes  the input's",
        "",
        "factor              values",
        "------------------  -----------------------------  -----",
        "objects.mass        1, 2.5                         2",
        "settings.clearance  0.001 to 0.01 by even factors  3",
        "objects.scale       one of 0.9 (1), 1 (2)          drawn",
        "body.betas.0        normal, 0 ± 1 within -2 to 2   drawn",
        "",
        "draws      5 of each combination, seed 0",
        "variants   180",
        "simulated  90 of them, where objects.mass < 2",
        "settings   stiffness 0.5",
        "shards     1 of up to 1,000 variants, webdataset",
        f"folder     {tmp_path / 'sweep'}",
    ]
