"""The loop of a sweep, with simulated outputs and engine: assignment and order of tasks."""

from __future__ import annotations

import heapq
from pathlib import Path

import pytest

from halfphysics.sweep.plan.layout import Layout
from halfphysics.sweep.run.driver import AHEAD, RATE, TARGET, Driver, SweepError
from halfphysics.sweep.run.engines import Death
from halfphysics.sweep.run.work import Done


class Outputs:
    """Outputs that only know which files exist."""

    def __init__(self, variants, batch=8, per_shard=80, made=(), sealed=()):
        self.layout = Layout(Path(), variants, batch, per_shard)
        self.made, self.sealed = set(made), set(sealed)
        self.failed = {}

    def done(self, shard):
        return shard in self.sealed

    def left(self, shard):
        return [b for b in self.layout.batches_of(shard) if b not in self.made]

    def all_there(self):
        return self.sealed == set(range(self.layout.shards))


class Clock:
    """An engine whose tasks take their stated times; some die.

    `deadly`: variant -> how often it kills its process. `crowded`: batches that die as long as
    none of their variants is left out.
    """

    def __init__(self, outputs, slots=2, seconds=0.1, deadly=(), crowded=(), dying=()):
        self.outputs, self.slots, self.seconds = outputs, slots, seconds
        self.deadly, self.crowded, self.dying = dict(deadly), set(crowded), set(dying)
        self.now, self.waiting, self.running = 0.0, [], []
        self.log, self.order, self.most = [], 0, 0
        self.busy = 0.0

    def submit(self, task):
        self.waiting.append(task)
        self.most = max(self.most, len(self.waiting) + len(self.running))
        self._begin()

    def _begin(self):
        while self.waiting and len(self.running) < self.slots:
            task = self.waiting.pop(0)
            variants = self._variants(task)
            took = 0.01 if task.kind == "seal" else sum(map(self._seconds, variants))
            self.busy += took
            self.order += 1
            heapq.heappush(self.running, (self.now + took, self.order, task, took))

    def _seconds(self, variant):
        return self.seconds(variant) if callable(self.seconds) else self.seconds

    def _variants(self, task):
        if task.kind == "seal":
            return []
        if task.kind == "variants":
            return list(range(task.first, task.first + task.count))
        batches = range(task.first, task.first + task.count)
        left_out = dict(task.dead)
        return [v for b in batches for v in self.outputs.layout.variants_of(b) if v not in left_out]

    def wait(self):
        if not self.running:
            return []
        self.now, _, task, took = heapq.heappop(self.running)
        self._begin()
        self.log.append(task)
        for variant in self._variants(task):
            if self.deadly.get(variant):
                self.deadly[variant] -= 1
                return [(task, Death())]
        if task.kind in self.dying:
            return [(task, Death("no luck"))]
        if task.kind == "seal":
            assert not self.outputs.left(task.shard), "sealed before its batches are there"
            assert task.shard not in self.outputs.sealed, "sealed twice"
            self.outputs.sealed.add(task.shard)
            return [(task, Done(took))]
        if task.kind == "variants":
            assert task.count == 1
            return [(task, Done(took))]
        batches = range(task.first, task.first + task.count)
        if self.crowded & set(batches) and self._variants(task):
            return [(task, Death())]
        assert not self.outputs.made & set(batches), "made twice"
        self.outputs.made.update(batches)
        self.outputs.failed.update(task.dead)
        kept = len(self._variants(task))
        return [(task, Done(took, kept=kept, causes=tuple(c for _, c in task.dead)))]

    def close(self):
        pass


class Told:
    """The messages of the driver."""

    def __init__(self):
        self.total = self.before = self.variants = self.deaths = 0

    def begin(self, variants):
        self.total = variants

    def found(self, variants):
        self.before += variants

    def ended(self, task, done):
        self.variants += done.variants

    def died(self, task, death):
        self.deaths += 1


def driven(outputs, engine):
    told = Told()
    driver = Driver(outputs, engine, told)
    driver.run()
    assert outputs.all_there()
    assert told.before + told.variants == told.total == outputs.layout.variants
    assert not any((driver._open, driver._tries, driver._suspects)), "nothing is remembered"
    return told


@pytest.mark.parametrize("slots", [1, 2, 7, 64])
@pytest.mark.parametrize("variants", [0, 1, 8, 79, 80, 81, 1234])
def test_everything_is_made_once_and_sealed(slots, variants):
    outputs = Outputs(variants)
    engine = Clock(outputs, slots)
    driven(outputs, engine)
    assert engine.most <= AHEAD * slots


@pytest.mark.parametrize("seconds", [0.001, 0.02, 0.3, 5.0])
def test_tasks_take_long_enough_and_not_much_longer(seconds):
    outputs = Outputs(20_000 if seconds < 0.1 else 2000, per_shard=4000)
    engine = Clock(outputs, 2, seconds)
    driven(outputs, engine)
    tasks = [t for t in engine.log if t.kind == "batches"]
    early = tasks[4 : len(tasks) // 2]
    took = [seconds * len(engine._variants(t)) for t in early]
    assert max(took) < max(1.5 * TARGET, 8 * seconds + 1e-9)
    assert sum(took) / len(took) > min(1.0, 8 * seconds)


@pytest.mark.parametrize("variants", [200, 1000])
@pytest.mark.parametrize("seconds", [0.01, 0.05, 0.2])
def test_all_slots_are_busy_to_the_end(variants, seconds):
    outputs = Outputs(variants, per_shard=1000)
    engine = Clock(outputs, 2, seconds)
    driven(outputs, engine)
    assert engine.busy / engine.now > 1.9


@pytest.mark.slow
def test_many_slots_get_longer_tasks():
    """One driver answers two thousand cores."""
    outputs = Outputs(800_000, per_shard=4000)
    engine = Clock(outputs, 2000, 0.1)
    driven(outputs, engine)
    tasks = [t for t in engine.log if t.kind == "batches"]
    # Not those at the beginning, nor those that share out the rest.
    took = [0.1 * len(engine._variants(t)) for t in tasks[2 * AHEAD * engine.slots :]]
    assert max(took) == pytest.approx(engine.slots / RATE, rel=0.1)
    assert engine.busy / engine.now > 0.9 * engine.slots


def test_uneven_variants_keep_all_slots_busy():
    """The pace changes tenfold in the middle."""
    outputs = Outputs(2000, per_shard=1000)
    engine = Clock(outputs, 4, lambda v: 0.02 if v < 1000 else 0.2)
    driven(outputs, engine)
    assert engine.busy / engine.now > 3.6


def test_what_is_there_is_not_made_again():
    outputs = Outputs(400, made=[10, 11, 13, *range(20, 30)], sealed=[0])
    outputs.made |= set(range(10))
    engine = Clock(outputs)
    told = driven(outputs, engine)
    assert told.before == 80 + 3 * 8 + 80
    made = [b for t in engine.log if t.kind == "batches" for b in range(t.first, t.first + t.count)]
    assert sorted(made) == [12, *range(14, 20), *range(30, 50)]
    assert sorted(t.shard for t in engine.log if t.kind == "seal") == [1, 2, 3, 4]


def test_a_death_by_chance_costs_a_repetition():
    outputs = Outputs(400)
    told = driven(outputs, Clock(outputs, deadly={3: 1, 200: 1, 399: 1}))
    assert told.deaths == 3
    assert outputs.failed == {}


def test_a_deadly_variant_is_found_and_the_rest_goes_on():
    outputs = Outputs(400)
    engine = Clock(outputs, deadly={17: 99, 20: 99, 399: 99})
    told = driven(outputs, engine)
    cause = Death().cause
    assert outputs.failed == {17: cause, 20: cause, 399: cause}
    # Twice in its batch, where it may have been in a larger task, and twice alone.
    assert told.deaths <= 2 * 3 + 2 * 3
    alone = [t.first for t in engine.log if t.kind == "variants"]
    assert set(alone) == {*range(16, 24), *range(392, 400)}
    assert sorted(alone) == sorted([*range(16, 24), *range(392, 400), 17, 20, 399])


def test_a_variant_that_dies_alone_but_once_is_made():
    outputs = Outputs(40)
    driven(outputs, Clock(outputs, deadly={17: 3}))
    assert outputs.failed == {}


def test_a_batch_that_dies_although_its_variants_do_not():
    outputs = Outputs(40)
    driven(outputs, Clock(outputs, crowded={2}))
    assert set(outputs.failed) == set(range(16, 24))
    assert all("alone survived" in cause for cause in outputs.failed.values())


@pytest.mark.parametrize("kind", ["batches", "seal"])
def test_where_every_process_dies_it_ends(kind):
    outputs = Outputs(4000)
    engine = Clock(outputs, dying={kind, "variants"})
    with pytest.raises(SweepError, match=r"in a row died.*no luck"):
        Driver(outputs, engine, Told()).run()
    assert outputs.sealed == set()


def test_what_cannot_be_written_ends_it():
    outputs = Outputs(400)
    engine = Clock(outputs)
    engine.wait = lambda: [(engine.running[0][2], Done(0.1, stop="disk full"))]
    with pytest.raises(SweepError, match="disk full"):
        Driver(outputs, engine, Told()).run()


def test_what_is_remembered_is_bounded():
    """With many open shards: one batch each."""
    outputs = Outputs(100_000, batch=10, per_shard=10)
    engine = Clock(outputs, 10, 0.1)
    driver = Driver(outputs, engine, Told())
    most = 0

    def measured(done=engine.wait):
        nonlocal most
        most = max(most, len(driver._open) + len(driver._left) + len(driver._first))
        return done()

    engine.wait = measured
    driver.run()
    assert outputs.all_there()
    assert most <= 2 * AHEAD * 10
