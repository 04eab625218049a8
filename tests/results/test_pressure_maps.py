"""Pressure maps of things: forces are kept, even pressure is even, sides and mistakes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.results import pressure_maps
from halfphysics.results.pressure_maps import pressure_map
from halfphysics.results.soft_contacts import SoftContacts
from support.results.soft_results import BED, FRAMES, TOP, soft_result, soft_rows


def forces(result):
    rows = result.soft_contacts
    return np.bincount(rows.frame, rows.pressure * rows.area, len(result))


def with_rows(*rows):
    table = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    return dataclasses.replace(soft_result(), soft_contacts=SoftContacts(**table))


def even(pressure=2000.0, half=0.1, pitch=0.02, normal=(0.0, 0.0, 1.0)):
    """A square under one pressure in frame 3."""
    grid = np.arange(-half + pitch / 2, half, pitch)
    xy = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    points = np.column_stack([xy, np.full(len(xy), TOP)])
    rows = soft_rows(3, np.full(len(xy), 0.01), points, pitch**2)
    rows["pressure"] = np.full(len(xy), pressure)
    rows["normal"] = np.tile(normal, (len(xy), 1))
    return rows


@pytest.mark.parametrize("cell", [0.005, 0.01, 0.03])
def test_the_force_of_every_frame_is_that_of_the_samples(cell):
    result = soft_result()
    made = pressure_map(result, cell=cell)
    assert (made.name, made.side, len(made)) == ("bed", "top", FRAMES)
    np.testing.assert_allclose(made.force, forces(result), rtol=1e-5, atol=1e-4)
    assert made.missed == 0.0


def test_even_pressure_is_even():
    """Inside to what cells as wide as the Gaussian tell; 2 kPa over 20 cm squared is 80 N."""
    made = pressure_map(with_rows(even()), cell=0.01)
    rows, columns = np.indices(made.pressure.shape[1:])
    x = made.corner[0] + made.cell * (columns + 0.5)
    y = made.corner[1] + made.cell * (rows + 0.5)
    inside = (np.abs(x) < 0.06) & (np.abs(y) < 0.06)
    np.testing.assert_allclose(made.pressure[3][inside], 2000.0, rtol=0.03)
    assert made.pressure[3][(np.abs(x) > 0.14) | (np.abs(y) > 0.14)].max() == 0.0
    assert made.force[3] == pytest.approx(80.0, rel=1e-5)
    assert made.area(1000.0)[3] == pytest.approx(0.04, rel=0.05)
    assert not made.pressure[2].any()
    assert not made.pressure[4].any()


def test_the_map_covers_the_thing_and_says_where_it_is():
    made = pressure_map(soft_result(), cell=0.01)
    np.testing.assert_allclose(made.outline, [[-BED[0] / 2, -BED[1] / 2], [BED[0] / 2, BED[1] / 2]])
    peak = np.unravel_index(made.pressure[1 + FRAMES // 4].argmax(), made.pressure.shape[1:])
    place = made.corner + made.cell * (np.array(peak[::-1]) + 0.5)
    assert np.linalg.norm(place - (0.7, 0.35)) < 0.02  # the ball
    assert made.peak.shape == made.pressure.shape[1:]


def test_of_a_tilted_pressure_the_side_that_carries_most_and_what_it_misses():
    steep = np.array([np.sqrt(0.84), 0.0, 0.4])
    both = pressure_map(with_rows(even(), even(pressure=500.0, normal=steep)))
    assert both.side == "top"
    assert 0.05 < both.missed < 0.2
    right = pressure_map(with_rows(even(), even(pressure=500.0, normal=steep)), side="right")
    assert right.force[3] == pytest.approx(500.0 * 0.04 * steep[0], rel=1e-5)


def test_a_plane_is_shown_around_what_presses():
    result = with_rows(even())
    scene = hp.Scene()
    soft = result.scene.statics["bed"].soft
    scene.add_static("bed", hp.Plane(offset=TOP), soft=soft)
    scene.add_object("ball", hp.Sphere(0.11), mass=1.0)
    made = pressure_map(dataclasses.replace(result, scene=scene))
    assert made.outline is None
    assert 0.3 < made.pressure.shape[1] * made.cell < 0.6
    assert made.force[3] == pytest.approx(80.0, rel=1e-5)


def test_mistakes_are_named():
    result = soft_result()
    with pytest.raises(InputError, match=r"without anything soft.*docs/soft"):
        pressure_map(dataclasses.replace(result, soft_contacts=None))
    with pytest.raises(InputError, match="nothing presses anything soft"):
        pressure_map(dataclasses.replace(result, soft_contacts=SoftContacts.none()))
    with pytest.raises(InputError, match=r"'bde'; did you mean bed.*Pressed are: bed"):
        pressure_map(result, "bde")
    with pytest.raises(InputError, match="side: found 'up', expected one of top, "):
        pressure_map(result, side="up")
    with pytest.raises(InputError, match=r"cell: expected a number from 0.001 to 1 .m., found 0"):
        pressure_map(result, cell=0)


def test_a_map_that_would_not_fit_into_memory_is_refused(monkeypatch):
    monkeypatch.setattr(pressure_maps, "MOST_NUMBERS", 10_000)
    with pytest.raises(InputError, match="over 10000 numbers; expected larger cells"):
        pressure_map(soft_result())
    assert pressure_map(soft_result(), cell=0.1).pressure.size < 10_000
