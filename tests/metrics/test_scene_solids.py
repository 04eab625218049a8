"""What a scene knows of a result's objects: files do not keep meshes from memory."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics
from halfphysics.cli import measures, measures_json
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.judging.judge import judge
from halfphysics.metrics.scene_solids import known_contacts, known_tracks
from halfphysics.results.result import Result


@pytest.fixture(scope="module")
def kept_and_lost(tmp_path_factory):
    """A result with a crate from memory, and the same from its file, where the crate has gone."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object(
        "crate", hp.Mesh(*hp.Box((0.2, 0.2, 0.2)).triangles()), mass=2.0, position=(2.5, 0, 0.1)
    )
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.5, 1.0, 0.1))
    rotations = np.zeros((8, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    upright = hp.Motion(np.zeros((8, 3)), rotations, 30.0)
    lowest = hp.Body.default().vertices(upright)[..., 2].min()
    standing = upright.with_frames(np.tile([0.0, 0.0, 0.001 - lowest], (8, 1)), rotations)
    whole = hp.simulate(standing, scene)
    path = tmp_path_factory.mktemp("lost") / "lost.npz"
    whole.save(path)
    lost = Result.load(path)
    with pytest.warns(HalfPhysicsWarning, match="left out of the scene: crate"):
        assert list(lost.scene.objects) == ["ball"]
    return whole, lost, path


def test_tracks_and_contacts_with_what_the_scene_lacks_are_not_known(kept_and_lost):
    whole, lost, _ = kept_and_lost
    assert list(known_tracks(whole.scene, whole.objects)) == ["crate", "ball"]
    assert list(known_tracks(lost.scene, lost.objects)) == ["ball"]
    assert known_contacts(whole).all()
    crate = lost.names.index("crate")
    its = (lost.contacts.subject == crate) | (lost.contacts.other == crate)
    assert its.any()
    assert np.array_equal(known_contacts(lost), ~its)


def test_what_does_not_need_a_lost_object_is_measured_without_it(kept_and_lost):
    whole, lost, _ = kept_and_lost
    crate = lost.names.index("crate")
    its = (lost.contacts.subject == crate) | (lost.contacts.other == crate)
    precision = metrics.contact_precision(lost)
    pushes = lost.contacts.strength > 0.0
    assert precision.contacts == (pushes & ~its).sum() > 0
    assert np.isnan(precision.distance[its]).all()
    assert metrics.contact_forces(lost).contacts == precision.contacts
    # The person stands far from the crate.
    slides = [metrics.stance_slide(result) for result in (whole, lost)]
    assert slides[0].simulated == slides[1].simulated
    assert slides[0].steps == slides[1].steps > 0
    kept = [
        line.strip()
        for line in whole.summary().splitlines()
        if "floats in" in line or "feet in stance" in line or "net force" in line
    ]
    assert len(kept) >= 2
    for line in kept:
        assert line in lost.summary()


def test_a_result_with_a_lost_object_is_evaluated_and_judged(kept_and_lost):
    whole, lost, path = kept_and_lost
    table = measures.of_result(lost, 0, progress=False)
    assert table == measures.of_result(whole, 0, progress=False)
    values = [measures_json.of_result(result, 0) for result in (whole, lost)]
    assert values[0]["simulated"]["floating"] == values[1]["simulated"]["floating"]
    (judged,) = judge(path, jobs=1)
    assert "left out of the scene: crate" in " ".join(judged.warnings)
    assert judged.error == ""
    assert judged.verdict is not None
    assert "floating_percent" in judged.verdict.values
