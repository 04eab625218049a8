"""Tables as data frames: every number and name of the table, and nothing else."""

from __future__ import annotations

import sys

import pytest

import halfphysics as hp
from halfphysics.results.inside import Inside
from support import small_results as small

LIBRARIES = ("pandas", "polars")
COLUMNS = [
    *("frame", "time_s", "person", "part", "other"),
    *("position_x_m", "position_y_m", "position_z_m", "normal_x", "normal_y", "normal_z"),
    *("impulse_x_Ns", "impulse_y_Ns", "impulse_z_Ns", "subject", "other_part"),
]


def column(frame, name):
    """Values of a column as a list, None where they are missing."""
    values = frame[name]
    listed = values.to_list() if hasattr(values, "to_list") else list(values)
    return [None if value is None or value != value else value for value in listed]


@pytest.mark.parametrize("library", LIBRARIES)
def test_every_value_is_that_of_the_table(library):
    result = small.result()
    contacts = result.contacts
    frame = contacts.to_dataframe(library)
    assert list(frame.columns) == COLUMNS
    assert len(frame) == len(contacts)
    assert column(frame, "frame") == contacts.frame.tolist()
    assert column(frame, "time_s") == [k / 30.0 for k in contacts.frame.tolist()]
    for vector in ("position", "normal", "impulse"):
        unit = {"position": "_m", "normal": "", "impulse": "_Ns"}[vector]
        for axis, letter in enumerate("xyz"):
            expected = getattr(contacts, vector)[:, axis].tolist()
            assert column(frame, f"{vector}_{letter}{unit}") == expected
    joints = dict(enumerate(hp.JOINT_NAMES)) | {-1: None}
    items = dict(enumerate(result.names)) | {-1: None}
    people = {-1: None, 0: "person0", 1: "person1"}
    kinds = {"part": joints, "other_part": joints, "other": items, "subject": items}
    for name, known in {**kinds, "person": people}.items():
        assert column(frame, name) == [known[k] for k in getattr(contacts, name).tolist()]


def test_names_are_categories_of_all_there_are():
    contacts = small.result().contacts
    pandas, polars = (contacts.to_dataframe(library) for library in LIBRARIES)
    for name, known in {"other": small.result().names, "part": hp.JOINT_NAMES}.items():
        assert tuple(pandas[name].cat.categories) == known
        assert tuple(polars[name].dtype.categories) == known
    forces = pandas.groupby("other", observed=True)["impulse_z_Ns"].sum()
    floor = contacts.impulse[contacts.other == 0, 2].sum()
    assert forces["floor"] == pytest.approx(floor, rel=1e-12)


def test_units_of_pandas():
    units = small.result().contacts.to_dataframe().attrs["units"]
    assert units["impulse_y_Ns"] == "N s"
    assert units["position_x_m"] == "m"
    assert units["time_s"] == "s"


def test_chosen_rows_keep_their_names():
    result = small.result()
    rows = result.contacts[result.contacts.person == 1]
    assert set(rows.to_dataframe()["person"]) == {"person1"}
    assert set(rows.to_dataframe()["other"]) == {"person0"}


def test_a_table_of_no_result_keeps_its_indices():
    made = Inside(
        frame=[0, 3], person=[0, -1], part=[5, -1], subject=[-1, 2], other=[1, 1], depth=[0.01, 0.0]
    )
    frame = made.to_dataframe()
    assert list(frame.columns) == ["frame", "person", "part", "subject", "other", "depth_m"]
    assert frame["other"].tolist() == [1, 1]
    assert frame["subject"].tolist() == [-1, 2]
    assert column(frame, "part") == [hp.JOINT_NAMES[5], None]
    assert frame["depth_m"].tolist() == [0.01, 0.0]


def test_tables_without_rows():
    for library in LIBRARIES:
        frame = small.result().inside.to_dataframe(library)
        assert len(frame) == 0
        assert "depth_m" in frame.columns


def test_pressure_of_support():
    frame = small.alone().people[0].support.pressure.to_dataframe()
    assert {"force_z_N", "position_x_m", "vertex"} <= set(frame.columns)


def test_what_is_missing_is_said(monkeypatch):
    contacts = small.result().contacts
    with pytest.raises(hp.errors.InputError, match=r"library: found 'dask', expected 'pandas' or"):
        contacts.to_dataframe("dask")
    with pytest.raises(hp.errors.InputError, match=r"library: found \['pandas'\], expected"):
        contacts.to_dataframe(["pandas"])
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(
        hp.errors.MissingDependencyError,
        match=r"data frames need polars: pip install 'halfphysics\[frames\]' \(or pip install pol",
    ):
        contacts.to_dataframe("polars")
