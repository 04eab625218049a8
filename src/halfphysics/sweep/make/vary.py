"""From a variant to the arguments of `simulate`, and to its result.

The order: read the input (or build the scenario), choose and shape the body, bring recorded hands
onto what they hold, put the motions on the ground if the plan requires it, change their speed and
frame rate, rotate and move them; then build the scene and change it item by item. `stock` caches
the data that neighbouring variants share.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from halfphysics.baselines import with_options
from halfphysics.body.match import check_match
from halfphysics.errors import InputError
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.world_cache import use_again
from halfphysics.sweep.make.motion_factors import placed, said_of_motion
from halfphysics.sweep.make.scene_factors import SceneFactors
from halfphysics.sweep.make.stock import Loaded, Source, Stock
from halfphysics.sweep.plan.factors import NOT_PLAIN, FactorName

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import World
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.variants import Variant


@dataclass(frozen=True, kw_only=True, eq=False)
class Ready:
    """The arguments of `simulate` for one variant.

    Attributes:
        motions: The reference motion of each person.
        scene: Statics and objects.
        bodies: The body of each person.
        settings: The settings of the simulation.
        sources: Every source file (motion, scene, meshes, models): its absolute "path", and
            "sha256" of its content.
        allow_mismatch: As in `simulate`.
    """

    motions: tuple[Motion, ...]
    scene: Scene
    bodies: tuple[Body, ...]
    settings: Settings
    sources: tuple[Source, ...] = ()
    allow_mismatch: bool = False


class Workshop:
    """Makes and simulates the variants of a plan, one after the other.

    The result of a variant never depends on the variants before it.

    Args:
        plan: Its `settings` and `grounded` are the same for all variants.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._stock = Stock()
        self._items = SceneFactors()
        self._world: World | None = None

    def make(self, variant: Variant) -> Ready:
        """The arguments of the simulation.

        Raises:
            InputError: A factor does not apply to this variant, or has an impossible value.
            FileError: A file cannot be used.
        """
        said = _by_group(variant.factors)
        timing = said_of_motion(variant.factors)
        loaded, bodies = self._people(variant, said)
        settings = _settings(loaded.clip.settings, self._plan.settings, said["settings"])
        acted = self._stock.adapted(variant.input, loaded, bodies, settings)
        motions = acted.clip.motions
        if self._plan.grounded:
            motions = self._stock.grounded(acted, bodies)
        motions = placed(self._stock.timed(motions, timing), bodies, timing)
        around = self._stock.scene(
            variant.scene, loaded, variant.input.ground, timing.get("speed", 1.0)
        )
        models = [source for body in bodies for source in (body.source, body.template_source)]
        files = [
            *loaded.sources,
            *around.sources,
            *({"path": str(s.path), "sha256": s.sha256} for s in models if s is not None),
        ]
        return Ready(
            motions=motions,
            scene=self._items.varied(around.scene, variant.factors),
            bodies=bodies,
            settings=settings,
            sources=tuple({(s["path"], s["sha256"]): s for s in files}.values()),
            allow_mismatch=variant.body.allow_mismatch,
        )

    def run(self, ready: Ready) -> Result:
        """The result of `simulate`, equal to the last bit.

        The world of the previous variant is reused if people and shapes are the same: building
        a world takes as long as simulating a second of motion with few contacts.

        Raises:
            MismatchError: A body has another gender or model than its motion.
        """
        for motion, body in zip(ready.motions, ready.bodies, strict=True):
            check_match(motion, body, allow_mismatch=ready.allow_mismatch)
        return follow(self._world_for(ready), ready.motions)

    def _world_for(self, ready: Ready) -> World:
        last = self._world
        if (
            last is not None
            and len(last.bodies) == len(ready.bodies)
            and all(a is b for a, b in zip(last.bodies, ready.bodies, strict=True))
            and use_again(last, ready.scene, ready.settings)
        ):
            return last
        # The old world is released first: two worlds would take twice the memory.
        self._world = None
        self._world = build_world(ready.bodies, ready.scene, ready.settings)
        return self._world

    def _people(
        self, variant: Variant, said: Mapping[str, Mapping[str, Any]]
    ) -> tuple[Loaded, tuple[Body, ...]]:
        """The clip and the body of each of its people."""
        from halfphysics.body.body import Body

        input, choice, shape = variant.input, variant.body, said["body"]
        if input.kind == "file":
            if said["scenario"]:
                option = next(iter(said["scenario"]))
                raise InputError(
                    f"scenario.{option}: {input.name} is a file, which has no options to vary"
                )
            loaded = self._stock.clip(input, {}, None)
            pairs = zip(loaded.clip.motions, loaded.clip.bodies, strict=True)
            return loaded, tuple(self._stock.body(choice, m, shape, own) for m, own in pairs)
        _check_options(input.name, said["scenario"])
        asked = choice.model is not None or choice.stature is not None or bool(shape)
        body = self._stock.body(choice, None, shape, None) if asked else None
        loaded = self._stock.clip(input, said["scenario"], body)
        return loaded, tuple(Body.default() if b is None else b for b in loaded.clip.bodies)


def _by_group(factors: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Factors of the body, the scenario and the settings, by group and name."""
    groups: dict[str, dict[str, Any]] = {"body": {}, "scenario": {}, "settings": {}}
    for factor, value in factors.items():
        name = FactorName.parse(factor)
        if name.group in groups:
            if name.bounds is not None:
                name.bounds.check(factor, value)
            groups[name.group][name.what] = value
    return groups


def _check_options(scenario: str, options: Iterable[str]) -> None:
    from halfphysics import scenarios

    known = [option for option in scenarios.options(scenario) if option not in NOT_PLAIN]
    for option in options:
        if option not in known:
            raise InputError(
                f"scenario.{option}: the scenario {scenario} has no such option, expected one of "
                f"{', '.join(known)}"
            )


def _settings(base: Settings, plan: Mapping[str, Any], factors: Mapping[str, Any]) -> Settings:
    """The clip's settings, overridden by the plan's, overridden by factors."""
    changes = {**plan, **factors}
    return with_options(base, changes)
