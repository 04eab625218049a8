"""Dents over time: of which things, in whose frame, how foam comes back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.results.dents import LEAST, dent_of, layer_of
from halfphysics.results.layer_rows import LayerRows
from halfphysics.results.result import ObjectTrack
from halfphysics.results.soft_contacts import SoftContacts
from support.results.small_result import small_result
from support.results.soft_results import BED, DEEP, FPS, FRAMES, TOP, bed_scene, soft_result

SECONDS = 1.0 / 30.0


def stamped(soft, frames=60, until=30, depth=0.04):
    """The dent of the bed by a flat stamp that is there before frame `until`."""
    bed = bed_scene().statics["bed"]
    base = layer_of(bed, bed.soft)
    grid = np.arange(-0.05, 0.0501, 0.01)
    xy = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    points = np.column_stack([xy, np.full(len(xy), BED[2] / 2)])
    n = len(xy)
    rows = LayerRows(
        frame=np.repeat(np.arange(until), n),
        position=np.tile(points, (until, 1)),
        normal=np.tile([0.0, 0.0, 1.0], (until * n, 1)),
        depth=np.full(until * n, depth),
        force=np.ones(until * n),
        area=np.full(until * n, 1e-4),
    )
    return dent_of("bed", base, rows, frames, SECONDS, soft)


def test_of_a_result_what_is_soft_and_pressed_dents():
    result = soft_result()
    assert list(result.dents) == ["bed"]
    dent = result.dents["bed"]
    assert len(dent) == FRAMES
    assert dent.name == "bed"
    # The ball's lowest sample is 7 mm beside its lowest point: 0.3 mm higher.
    deepest = int(np.argmax(dent.depth.max(axis=1)))
    assert deepest == 1 + FRAMES // 4
    assert dent.depth.max() == pytest.approx(DEEP, abs=4e-4)
    assert (dent.depth[0] == 0.0).all()
    np.testing.assert_array_equal(dent.at(0), dent.layer.surface)


def test_the_surface_is_nowhere_above_what_presses():
    """Every sample of every frame, on the person's back and under the ball."""
    result = soft_result()
    dent, rows = result.dents["bed"], result.soft_contacts
    bed = result.scene.statics["bed"].position
    for frame in range(FRAMES):
        mine = rows.at(frame)
        local = mine.position - bed
        up = local + mine.depth[:, None] * mine.normal
        samples = dent.layer.pressed(up, mine.normal, mine.depth)
        corners = dent.at(frame)[samples.corner]
        z = np.einsum("nk,nki->ni", samples.share, corners)[:, 2]
        assert (z <= local[:, 2] + LEAST).all()


def test_a_result_without_anything_soft_has_none():
    result = dataclasses.replace(soft_result(), soft_contacts=None)
    assert dict(result.dents) == {}
    empty = dataclasses.replace(soft_result(), soft_contacts=SoftContacts.none())
    assert dict(empty.dents) == {}
    assert not hasattr(small_result(), "dents")  # what is drawn need not be a result


def test_foam_springs_back_in_part_and_then_slowly():
    """w = s h / (1 + h) of what has crept to s, which decays with recovery (1 + h)."""
    soft = hp.Soft(0.15, 5e4, hysteresis=0.5, recovery=0.4)
    dent = stamped(soft)
    under = np.linalg.norm(dent.layer.surface[dent.vertices] - (0.0, 0.0, BED[2] / 2), axis=1)
    middle = dent.depth[:, under.argmin()]
    np.testing.assert_allclose(middle[:30], 0.04, atol=1e-6)
    crept = 0.04 * (1.0 - np.exp(-30 * SECONDS / 0.4))
    time = SECONDS * np.arange(1, 31)
    left = crept * 0.5 / 1.5 * np.exp(-time / (0.4 * 1.5))
    np.testing.assert_allclose(middle[30:], np.where(left < LEAST, 0.0, left), atol=1e-6)


def test_what_is_linear_springs_back_at_once():
    dent = stamped(hp.Soft(0.15, 5e4, law="linear"))
    assert dent.depth[29].max() > 0.03
    assert not dent.depth[30:].any()


def test_a_thing_that_moves_dents_in_its_own_frame():
    """The bed as an object that turns and travels with the ball: the same dents as at rest."""
    still = soft_result()
    turn = rot.exp(np.array([0.3, -0.2, 1.0]))
    shift = np.array([1.0, 2.0, 0.5])
    bed = still.scene.statics["bed"]
    scene = hp.Scene()
    scene.add_object("bed", hp.Box(BED), mass=20.0, position=bed.position, soft=bed.soft)
    scene.add_object("ball", hp.Sphere(0.11), mass=1.0, position=(0.7, 0.35, 1.0))
    rows = still.soft_contacts
    moved = dataclasses.replace(
        rows,
        position=rot.rotate(turn, rows.position) + shift,
        normal=rot.rotate(turn, rows.normal),
    )
    track = ObjectTrack(
        position=np.tile(rot.rotate(turn, bed.position) + shift, (FRAMES, 1)),
        quaternion=np.tile(turn, (FRAMES, 1)),
    )
    result = dataclasses.replace(
        still,
        scene=scene,
        names=("bed", "ball", "person"),
        objects={"bed": track, **still.objects},
        soft_contacts=moved,
    )
    ours, theirs = result.dents["bed"], still.dents["bed"]
    middle = FRAMES // 4
    assert ours.depth[middle].max() == pytest.approx(theirs.depth[middle].max(), abs=1e-4)
    place = ours.layer.surface[ours.vertices[ours.depth[middle].argmax()]]
    assert np.linalg.norm(place[:2] - (0.7, 0.35)) < 0.02
    assert place[2] == pytest.approx(BED[2] / 2)


def test_between_frames_a_dent_is_between_theirs():
    dent = soft_result().dents["bed"]
    half = dent.sampled(np.array([2, 5]), np.array([3, 6]), np.array([0.5, 0.0]))
    np.testing.assert_allclose(half.depth[0], 0.5 * (dent.depth[2] + dent.depth[3]), atol=1e-8)
    np.testing.assert_array_equal(half.depth[1], dent.depth[5])


def test_the_same_result_gives_the_same_bits():
    first = soft_result().dents["bed"]
    soft_result.cache_clear()
    again = soft_result().dents["bed"]
    assert first.depth.tobytes() == again.depth.tobytes()
    assert first.layer.surface.tobytes() == again.layer.surface.tobytes()


def test_the_top_of_the_bed_is_where_the_tests_say():
    bed = bed_scene().statics["bed"]
    assert bed.position[2] + BED[2] / 2 == pytest.approx(TOP)
    assert soft_result().fps == FPS
