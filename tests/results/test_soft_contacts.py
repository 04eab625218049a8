"""SoftContacts: rows of pressures, checked, single in files, and named in data frames."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.results.naming import Naming
from halfphysics.results.soft_contacts import SoftContacts


def rows(**changes):
    columns = {
        "frame": [0, 1, 1],
        "layer": [0, 0, 0],
        "other": [2, 2, 1],
        "part": [3, 3, -1],
        "vertex": [17, 18, -1],
        "position": np.eye(3),
        "normal": [[0.0, 0.0, 1.0]] * 3,
        "depth": [0.01, 0.02, 0.03],
        "pressure": [1e3, 2e3, 3e3],
        "area": [1e-4, 2e-4, 3e-4],
    }
    return SoftContacts(**{name: np.array(v) for name, v in {**columns, **changes}.items()})


def test_the_force_is_pressure_times_area_along_the_normal():
    assert rows().force == pytest.approx(np.array([[0, 0, 0.1], [0, 0, 0.4], [0, 0, 0.9]]))


def test_rows_of_a_frame_are_chosen_by_it():
    assert rows().at(1).vertex.tolist() == [18, -1]
    assert len(rows().at(5)) == 0


@pytest.mark.parametrize("name", ["depth", "pressure", "area"])
def test_a_layer_never_pulls(name):
    with pytest.raises(InputError, match=f"soft_contacts.{name}: found -1, expected 0 or more"):
        rows(**{name: [1.0, -1.0, 1.0]})


def test_not_a_number_and_other_lengths_are_refused():
    with pytest.raises(InputError, match=r"soft_contacts\.pressure: .*NaN"):
        rows(pressure=[1.0, np.nan, 1.0])
    with pytest.raises(InputError, match="found 2 rows and 3"):
        rows(pressure=[1.0, 1.0])


def test_it_says_what_it_is():
    assert repr(rows()) == "SoftContacts(3 rows in frames 0 to 1, pressures up to 3 kPa)"
    assert repr(SoftContacts.none()) == "SoftContacts(none)"


def test_data_frames_have_names_and_units():
    pytest.importorskip("pandas")
    frame = rows().named(Naming(("bed", "ball", "person"), 1, 30.0)).to_dataframe()
    assert frame["layer"].tolist() == ["bed"] * 3
    assert frame["other"].tolist() == ["person", "person", "ball"]
    assert frame["pressure_Pa"].tolist() == [1e3, 2e3, 3e3]
    assert {"depth_m", "area_m2", "position_x_m", "time_s"} <= set(frame.columns)
