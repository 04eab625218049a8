"""Variants for the tests of sweeps, made by hand."""

from halfphysics.sweep.make.vary import Workshop
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.inputs import Input, Inputs
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.plan.variants import Variant


def workshop(**plan):
    """A workshop of a plan with these settings; `grounded` too."""
    return Workshop(Plan(inputs=(Inputs(scenarios=("kick_ball",)),), **plan))


def scenario(name, body=None, scene=None, factors=None, **options):
    """A variant of a scenario, with options of the input."""
    return _variant(Input(kind="scenario", name=name, options=options), body, scene, factors)


def clip(path, body=None, scene=None, factors=None, ground=True, **options):
    """A variant of a motion file."""
    given = Input(kind="file", name=str(path), path=path, options=options, ground=ground)
    return _variant(given, body, scene, factors)


def _variant(given, body, scene, factors):
    return Variant(
        number=0,
        input=given,
        body=body or BodyChoice(),
        scene=scene or SceneChoice(),
        factors=dict(factors or {}),
    )
