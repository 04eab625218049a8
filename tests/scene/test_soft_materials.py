"""Materials: values within the ranges of their sources."""

from __future__ import annotations

import pytest

from halfphysics.scene.soft_materials import MATERIALS, of_indentation


def test_the_modulus_of_an_indentation_test_makes_the_layer_carry_what_the_test_says():
    """A disc of 323 cm^2, 25 mm into 100 mm of foam of 35 lbf."""
    stiffness = of_indentation(35.0) / 0.1
    assert stiffness * 0.025 * 0.0323 == pytest.approx(35.0 * 4.44822, rel=1e-12)


@pytest.mark.parametrize(("name", "least", "most"), [("sofa", 25, 40), ("mattress", 25, 40)])
def test_seats_and_mattresses_are_as_firm_as_the_trade_sells_them(name, least, most):
    """ILD at 25 % [lbf], and the ratio of the forces at 65 and 25 % (comfort factor 1.8 to 3.5)."""
    material = MATERIALS[name]
    assert of_indentation(least) <= material.modulus <= of_indentation(most)
    ratio = _pressure(material, 0.65) / _pressure(material, 0.25)
    assert 1.8 <= ratio <= 3.5


def test_a_landing_mat_is_as_stiff_as_was_measured():
    """Force over displaced volume, 1.3e5 to 1.8e5 Pa/m, at a mat of 0.2 m."""
    assert 1.3e5 <= MATERIALS["mat"].modulus / 0.2 <= 1.8e5


def test_a_pillow_recovers_within_seconds_and_the_others_at_once():
    assert 2.0 <= MATERIALS["pillow"].recovery <= 10.0
    assert all(m.recovery <= 1.0 for name, m in MATERIALS.items() if name != "pillow")


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_says_where_its_values_come_from(name):
    assert len(MATERIALS[name].source) > 60


def _pressure(material, share):
    return material.modulus * share * (1.0 + material.densification * share**4)
