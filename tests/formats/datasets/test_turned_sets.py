"""Files of recorded data sets that are turned or scaled against their rule are read upright."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from support.files import recorded_sets as sets
from support.files.wrong_axes import heights, walker

#: Heights of joints agree to this [m]: units are found to within rounding in single precision.
SAME = 1e-5


def archive(folder, fields):
    np.savez(folder / "a.npz", **fields)
    return folder / "a.npz"


#: Name -> a file of a person, at its place in a folder.
FILES = {
    "interx": lambda folder, one: archive(folder, sets.interx_fields(one)),
    "humanclaw": lambda folder, one: archive(folder, sets.humanclaw_fields(one)),
    "interact": sets.interact,
    "parahome": lambda folder, one: sets.parahome(folder, one, sets.Z_UP),
    "intercap": lambda folder, one: sets.dump(
        folder / "res.pkl", sets.intercap_fields(one, np.zeros((sets.FRAMES, 24)))
    ),
    "interhuman": lambda folder, one: sets.dump(
        folder / "a.pkl", sets.interhuman_fields([one, one])
    ),
    "emdb": lambda folder, one: sets.dump(folder / "a.pkl", sets.emdb_fields(one, sets.Y_UP)),
    "3dpw": lambda folder, one: sets.dump(folder / "a.pkl", sets.threedpw_fields([one], sets.Y_UP)),
}
#: The axis that is up by the rule of each.
RULES = {"interhuman": "z", "parahome": "z", "intercap": "-y"}


def walking(monkeypatch, name) -> tuple[hp.Motion, tuple[np.ndarray, np.ndarray]]:
    """Who walks for three seconds, at the rate of a data set, and the same as arrays."""
    motion = walker().resample(120.0) if name == "interx" else walker()
    monkeypatch.setattr(sets, "FRAMES", len(motion))
    return motion, (motion.translation, np.array(motion.rotations))


def read(path) -> tuple[hp.Motion, str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        motion = hp.Motion.load(path)
    return motion, " ".join(str(warning.message) for warning in caught)


@pytest.mark.parametrize("up", ["z", "y", "-y"])
@pytest.mark.parametrize("name", FILES)
def test_whatever_axis_is_up(tmp_path, monkeypatch, name, up):
    asked, someone = walking(monkeypatch, name)
    for constant in ("Y_UP", "Z_UP", "Y_DOWN"):
        monkeypatch.setattr(sets, constant, axes_of(up))
    motion, told = read(FILES[name](tmp_path, someone))
    assert np.abs(heights(motion) - heights(asked)).max() < SAME
    wrong = up != RULES.get(name, "y")
    assert (f"along {up}" in told) == wrong, told


@pytest.mark.parametrize("name", FILES)
def test_centimetres_are_told(tmp_path, monkeypatch, name):
    asked, someone = walking(monkeypatch, name)
    placed = sets.in_axes

    def scaled(*args):
        translation, rotations = placed(*args)
        return 100.0 * translation, rotations

    monkeypatch.setattr(sets, "in_axes", scaled)
    motion, told = read(FILES[name](tmp_path, someone))
    assert np.abs(heights(motion) - heights(asked)).max() < SAME
    assert "translations are in" in told
