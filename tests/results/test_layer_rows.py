"""What presses a soft thing: as a layer, as the one with the samples, beside another soft thing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.results.layer_rows import pressed_things, rows_of
from support.results.soft_results import FRAMES, RADIUS, soft_result


def of(layers):
    """The result of the bed and the ball with other layers: (bed, ball)."""
    result = soft_result()
    scene = hp.Scene()
    bed = result.scene.statics["bed"]
    scene.add_static("bed", bed.shape, position=bed.position, soft=layers[0])
    scene.add_object("ball", hp.Sphere(RADIUS), mass=1.0, soft=layers[1])
    rows = result.soft_contacts
    return dataclasses.replace(result, scene=scene, soft_contacts=rows[rows.other == 1])


def test_a_soft_ball_on_a_hard_bed_is_what_dents():
    result = of((None, hp.Soft(0.05, 4e4)))
    contacts = result.soft_contacts
    assert [thing.name for thing in pressed_things(result, contacts)] == ["ball"]
    rows = rows_of(result, contacts, 1)
    np.testing.assert_array_equal(rows.depth, contacts.depth)
    # A sample of a thing is where it is; what presses a layer is put on its surface.
    # Outward from the ball is down, and the samples are on its lower half.
    np.testing.assert_allclose(rows.normal, np.tile([0.0, 0.0, -1.0], (len(rows), 1)))
    np.testing.assert_allclose(np.linalg.norm(rows.position, axis=1), RADIUS, atol=1e-6)
    dent = result.dents["ball"]
    assert dent.depth[1 + FRAMES // 4].max() == pytest.approx(0.05 * 0.9, abs=0.006)
    low = dent.at(1 + FRAMES // 4)[:, 2].min()
    assert -RADIUS + 0.03 < low < -RADIUS + 0.065


def test_two_soft_things_share_the_depth_by_their_softness():
    result = of((hp.Soft(0.1, 3e4), hp.Soft(0.05, 1e4)))
    contacts = result.soft_contacts
    assert len(pressed_things(result, contacts)) == 2
    bed, ball = (rows_of(result, contacts, k) for k in (0, 1))
    np.testing.assert_allclose(bed.depth, 0.25 * contacts.depth)
    np.testing.assert_allclose(ball.depth, 0.75 * contacts.depth)
    np.testing.assert_allclose(bed.force, ball.force)


def test_what_is_hard_is_not_pressed():
    result = of((None, None))
    assert pressed_things(result, result.soft_contacts) == []
    assert dict(result.dents) == {}
