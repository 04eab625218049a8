"""The simulation for each number of a sweep, computed without a list of all simulations.

The number is written in the mixed radix of the axes: inputs, bodies, scenes, the factors with lists
or ranges in the plan's order, and the samples; the first varies slowest, so that neighbours share
clip, body and scene. A drawn value is a hash of seed, number and name (`sweep.draws`).
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from halfphysics.errors import InputError
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.draws import Stream
from halfphysics.sweep.plan.inputs import Input, read_line
from halfphysics.sweep.plan.layout import DIGITS, key_of
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.plan.values import Value

#: The largest number of variants of a sweep, so that keys in shards sort like numbers.
MOST = 10**DIGITS


@dataclass(frozen=True, kw_only=True, slots=True)
class Variant:
    """One simulation of a sweep.

    Attributes:
        number: Index in the sweep, from 0.
        input: The motion file or scenario.
        body: The body; the path of a model can be opened.
        scene: The scene; the path of a file can be opened.
        factors: Name -> value of every factor of the plan, in the plan's order.
    """

    number: int
    input: Input
    body: BodyChoice
    scene: SceneChoice
    factors: Mapping[str, Value]

    @property
    def key(self) -> str:
        """Its name in the shards: the number in nine digits."""
        return key_of(self.number)

    def values(self) -> dict[str, Value]:
        """The values of the names in expressions."""
        return {
            **self.factors,
            "input": self.input.name,
            "body": self.body.name,
            "scene": self.scene.name,
        }


class Variants(Sequence[Variant]):
    """All variants of a plan; each is computed on access, in any order, in any process."""

    def __init__(self, plan: Plan, inputs: Sequence[str]) -> None:
        """
        Args:
            plan: The plan.
            inputs: The lines from `resolve_inputs` for this plan, a list or an `InputList`.

        Raises:
            InputError: No inputs, or more variants than can be numbered.
        """
        if not len(inputs):
            raise InputError("inputs: found none, expected one motion or scenario at least")
        self.plan = plan
        self.inputs = inputs
        self._bodies = tuple(
            body if body.model is None else replace(body, path=plan.base / body.model)
            for body in plan.bodies
        )
        self._scenes = tuple(
            scene if scene.file is None else replace(scene, path=plan.base / scene.file)
            for scene in plan.scenes
        )
        listed = {name: axis.listed() for name, axis in plan.axes.items()}
        #: The last axis varies fastest; of the samples only the count matters.
        self._axes = tuple((name, values, len(values)) for name, values in reversed(listed.items()))
        self._drawn = tuple((k, v.draw, Stream(plan.seed, k)) for k, v in plan.drawn.items())
        self._blank = dict.fromkeys(plan.factors)
        self._length = len(inputs) * len(self._bodies) * len(self._scenes) * plan.samples
        for _, _, count in self._axes:
            self._length *= count
        if self._length > MOST:
            raise InputError(
                f"factors: found {self._length:,} variants, expected at most {MOST:,}; draw "
                "some factors from distributions instead of combining all values"
            )
        self._keep = plan.expressions("keep")
        self._last: tuple[int, Input] | None = None

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(self._length))]
        number = operator.index(number)
        if not -self._length <= number < self._length:
            raise IndexError(f"variant {number} of {self._length}")
        number %= self._length
        rest = number // self.plan.samples
        factors = self._blank.copy()
        for name, values, count in self._axes:
            rest, place = divmod(rest, count)
            factors[name] = values[place]
        for name, draw, stream in self._drawn:
            factors[name] = draw(stream, number)
        rest, scene = divmod(rest, len(self._scenes))
        place, body = divmod(rest, len(self._bodies))
        return Variant(
            number=number,
            input=self._input(place),
            body=self._bodies[body],
            scene=self._scenes[scene],
            factors=factors,
        )

    def keeps(self, variant: Variant) -> bool:
        """Whether a variant is to be simulated: all `keep` conditions of the plan hold for it.

        Raises:
            InputError: Values that a condition cannot compare or compute with.
        """
        if not self._keep:
            return True
        values = variant.values()
        return all(holds(values) for holds in self._keep)

    def sample(self, count: int) -> list[int]:
        """Sorted numbers of up to `count` variants, chosen at random but always the same.

        All numbers if the sweep has at most `count` variants.
        """
        if count >= self._length:
            return list(range(self._length))
        chosen: set[int] = set()
        for even in Stream(self.plan.seed, "").uniforms(self._length):
            chosen.add(int(even * self._length))
            if len(chosen) == count:
                break
        return sorted(chosen)

    def _input(self, place: int) -> Input:
        last = self._last
        if last is None or last[0] != place:
            line = self.inputs[place]
            last = self._last = (place, read_line(line, self.plan.inputs, self.plan.base))
        return last[1]


def first_inputs(variants: Variants, count: int) -> list[Input]:
    """The first inputs of a sweep, up to `count`."""
    plan = variants.plan
    return [read_line(line, plan.inputs, plan.base) for line in islice(variants.inputs, count)]
