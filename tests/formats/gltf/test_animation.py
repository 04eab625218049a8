"""Keys of glTF animations: interpolation as the specification has it, and rates."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

from halfphysics.formats.gltf.animation import Animation, Keys
from halfphysics.formats.gltf.container import Container
from support.files.gltf_rigs import Builder

#: Times are taken a tick of single precision later [s]; values change by some per second.
TICK = 1e-5
RNG = np.random.default_rng(0)
TIMES = np.cumsum(RNG.uniform(0.1, 0.5, 9))
AT = np.linspace(TIMES[0], TIMES[-1], 200)


def test_linear_places_and_turns_along_the_shortest_arc():
    places = RNG.normal(size=(9, 3))
    asked = np.stack([np.interp(AT, TIMES, places[:, k]) for k in range(3)], axis=1)
    assert np.abs(Keys(TIMES, places, "LINEAR").at(AT, turns=False) - asked).max() < TICK
    turns = Rotation.random(9, random_state=1)
    quaternions = turns.as_quat()[:, [3, 0, 1, 2]] * np.where(np.arange(9) % 2, 1, -1)[:, None]
    found = Rotation.from_quat(
        Keys(TIMES, quaternions, "LINEAR").at(AT, turns=True)[:, [1, 2, 3, 0]]
    )
    assert (found.inv() * Slerp(TIMES, turns)(AT)).magnitude().max() < 20 * TICK


def test_steps_hold_until_the_next_key():
    values = np.arange(9.0)[:, None]
    found = Keys(TIMES, values, "STEP").at(np.r_[TIMES, TIMES[1:] - 1e-3], turns=False)[:, 0]
    assert found.tolist() == [*range(9), *range(8)]
    # The time of a key, rounded to single precision, is still the key's.
    rounded = Keys(TIMES.astype(np.float32).astype(float), values, "STEP").at(TIMES, turns=False)
    assert rounded[:, 0].tolist() == list(range(9))


def test_cubic_splines():
    values, into, out = RNG.normal(size=(3, 9, 3))
    found = Keys(TIMES, values, "CUBICSPLINE", (into, out)).at(AT, turns=False)
    for low in range(8):
        rows = np.searchsorted(TIMES, AT, side="right") - 1 == low
        ends = slice(low, low + 2)
        slopes = np.stack([out[low], into[low + 1]])
        asked = CubicHermiteSpline(TIMES[ends], values[ends], slopes)(AT[rows])
        assert np.abs(found[rows] - asked).max() < 10 * TICK


def test_ends_and_single_keys():
    keys = Keys(TIMES, np.arange(9.0)[:, None], "LINEAR")
    assert keys.at(np.array([-1.0, 99.0]), turns=False).ravel().tolist() == [0.0, 8.0]
    assert Keys(TIMES[:1], np.ones((1, 3)), "LINEAR").at(AT, turns=False).shape == (200, 3)


def rate_of(tmp_path, *times: np.ndarray, **fields) -> float | None:
    builder = Builder()
    animation = builder.animation("a")
    animation |= fields
    for node, each in enumerate(times):
        builder.node()
        builder.animate(animation, node, "translation", np.asarray(each), np.zeros((len(each), 3)))
    container = Container(builder.glb(tmp_path / "a.glb"))
    return Animation(container, 0, len(times)).rate(set(range(len(times))))


@pytest.mark.parametrize(
    "fps", [15.0, 24.0, 29.97002997002997, 30.0, 60.0, 59.94005994005994, 120.0]
)
def test_rates(tmp_path, fps):
    long = np.arange(5000) / fps
    assert rate_of(tmp_path, long) == pytest.approx(fps, rel=1e-12)
    assert rate_of(tmp_path, long + 1 / 24) == pytest.approx(fps, rel=1e-12)
    # Channels whose keys were reduced, on the grid of another.
    kept = np.sort(RNG.choice(300, 40, replace=False))
    assert rate_of(tmp_path, long[:300], long[kept]) == pytest.approx(fps, rel=1e-12)


def test_rates_that_are_none_or_said(tmp_path):
    assert rate_of(tmp_path, np.cumsum(RNG.uniform(0.01, 0.1, 50))) is None
    assert rate_of(tmp_path, np.array([0.0, 1.0, 2.0])) is None  # made by hand
    assert rate_of(tmp_path, np.array([0.5])) is None
    assert rate_of(tmp_path, np.array([0.0, 0.5]), extras={"fps": 47.5}) == 47.5
    assert rate_of(tmp_path, np.arange(20) / 30.0, extras={"fps": "fast"}) == 30.0
