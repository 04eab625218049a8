"""Soft: the numbers of a layer, materials by name, and the messages about impossible ones."""

from __future__ import annotations

import copy
import pickle

import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.scene.soft import DAMPING_TIME, checked_soft
from halfphysics.scene.soft_materials import MATERIALS


def test_damping_is_a_hundredth_of_a_second_of_the_stiffness_where_it_is_not_given():
    assert hp.Soft(0.1, 1e5).damping == DAMPING_TIME * 1e5
    assert hp.Soft(0.1, 1e5, damping=0.0).damping == 0.0


@pytest.mark.parametrize("name", MATERIALS)
def test_a_named_layer_keeps_its_modulus_at_any_thickness(name):
    usual, thin = hp.Soft.named(name), hp.Soft.named(name, thickness=0.05)
    modulus = MATERIALS[name].modulus
    for layer in (usual, thin):
        assert layer.stiffness * layer.thickness == pytest.approx(modulus, rel=1e-12)
        assert layer.damping == pytest.approx(MATERIALS[name].damping_time * layer.stiffness)
    assert thin.thickness == 0.05


def test_a_thinner_layer_is_of_the_same_foam():
    layer = hp.Soft(0.2, 1e5, damping=500.0)
    thin = layer.of_thickness(0.05)
    assert (thin.thickness, thin.stiffness, thin.damping) == (0.05, 4e5, 2000.0)


@pytest.mark.parametrize(
    ("arguments", "found", "expected"),
    [
        ({"thickness": -0.1, "stiffness": 1e5}, "thickness is -0.1", ">= 0.002"),
        ({"thickness": float("nan"), "stiffness": 1e5}, "thickness is nan", "finite"),
        ({"thickness": "thick", "stiffness": 1e5}, "thickness is 'thick'", "finite"),
        ({"thickness": 3.0, "stiffness": 1e5}, "thickness is 3.0", "<= 2.0"),
        ({"thickness": 0.1, "stiffness": 0.0}, "stiffness is 0.0", "Pa/m"),
        ({"thickness": 0.1, "stiffness": 1e5, "damping": -1.0}, "damping is -1.0", "Pa s/m"),
        ({"thickness": 0.1, "stiffness": 1e5, "law": "gel"}, "law is 'gel'", "'foam' or 'linear'"),
        ({"thickness": 0.1, "stiffness": 1e5, "recovery": 0.0}, "recovery is 0.0", "[s]"),
        ({"thickness": 0.1, "stiffness": 1e5, "hysteresis": -1}, "hysteresis is -1", ">= 0.0"),
    ],
)
def test_impossible_numbers_are_refused(arguments, found, expected):
    with pytest.raises(InputError) as caught:
        hp.Soft(**arguments)
    assert f"Soft.{found}" in str(caught.value)
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("soffa", "no material called 'soffa'; did you mean 'sofa'?"),
        ({"thicknes": 0.1}, "unknown field 'thicknes'; did you mean 'thickness'?"),
        ({"thickness": 0.1}, "found no stiffness"),
        ({"material": "gold"}, "no material called 'gold'"),
        (3, "found 3, expected halfphysics.Soft"),
        (True, "found True, expected halfphysics.Soft"),
    ],
)
def test_what_is_no_layer_is_refused_with_the_way_out(given, words):
    with pytest.raises(InputError, match="static 'bed'") as caught:
        checked_soft("static 'bed'", given)
    assert words in str(caught.value)


def test_fields_make_a_layer_and_a_material_fills_in_what_is_not_given():
    assert checked_soft("x", {"thickness": 0.1, "stiffness": 1e5}) == hp.Soft(0.1, 1e5)
    made = checked_soft("x", {"material": "sofa", "recovery": 2.0})
    assert (made.recovery, made.thickness) == (2.0, MATERIALS["sofa"].thickness)


@pytest.mark.parametrize("layer", [hp.Soft(0.1, 1e5, law="linear"), hp.Soft.named("pillow")])
def test_a_document_gives_the_same_layer_and_so_do_copies(layer):
    assert hp.Soft(**layer.document) == layer
    assert copy.deepcopy(layer) == layer == pickle.loads(pickle.dumps(layer))
