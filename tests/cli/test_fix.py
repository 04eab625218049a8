"""halfphysics fix: files, numbers, page, mistakes."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import main
from support.damage import floating
from support.files import video_files as files
from support.files.video_files import Person
from support.made_clips import standing


@pytest.fixture
def clip(tmp_path):
    path = tmp_path / "clip.npz"
    floating(standing(), hp.Body.default()).save(path)
    return path


def test_it_writes_the_format_that_it_read(clip, tmp_path, capsys):
    out = tmp_path / "fixed.npz"
    assert main(["fix", str(clip), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "floated by 5.0 cm: put on the ground" in said
    assert "Phys-Err" in said
    assert f"written: {out} (amass-smplx)" in said
    made = hp.Motion.load(out)
    assert made.origin.format == hp.Motion.load(clip).origin.format
    assert np.ptp(made.translation[:, 2]) < 1e-3
    assert hp.Motion.load(clip).translation[0, 2] - made.translation[0, 2] == pytest.approx(
        0.05, abs=2e-3
    )


def test_without_out_nothing_is_written(clip, tmp_path, capsys):
    assert main(["fix", str(clip)]) == 0
    assert list(tmp_path.iterdir()) == [clip]
    assert "before" in capsys.readouterr().out


def test_page_and_result(clip, tmp_path):
    page, result = tmp_path / "page.html", tmp_path / "result.npz"
    assert main(["fix", str(clip), "--page", str(page), "--result", str(result)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "before (left) and after (right)" in text
    assert "floated by 5.0 cm" in text
    assert len(hp.Result.load(result)) == len(hp.Motion.load(clip))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["gone.npz"], "gone.npz"),
        (["C", "--out", "no/fixed.npz"], "does not exist"),
        (["C", "--page", "page.png"], "expected a name that ends in .html"),
        (["C", "--no-ground"], "--no-ground: found no scene"),
        (["C", "--smooth", "0"], "smooth: expected a number above 0 [Hz]"),
        (["C", "--out", "C"], "input"),
        (["C", "--out", "fixed.txt"], "found suffix '.txt'"),
    ],
)
def test_a_mistake_is_one_message(clip, tmp_path, capsys, arguments, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["fix", *(str(clip) if a == "C" else a for a in arguments)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("halfphysics: error: ")
    assert words in err
    assert list(tmp_path.iterdir()) == [clip]


def test_numbered_files_do_not_overwrite_what_was_read(tmp_path, capsys):
    body = hp.Body.default()
    translation, rotations = floating(standing(), body).rebased(body, "y").in_file_axes()
    people = [
        Person(name, np.arange(len(translation)), translation + np.array([x, 0, 0]), rotations)
        for name, x in (("3", 0.0), ("8", 1.5))
    ]
    source = files.joblib_file(tmp_path / "ow_1.pkl", files.wham_data(people))
    before = source.read_bytes()
    out = tmp_path / "ow.pkl"
    assert main(["fix", str(source), "--out", str(out), "--format", "gvhmr"]) == 2
    assert "ow_1.pkl: this is the input" in capsys.readouterr().err
    assert source.read_bytes() == before
    assert list(tmp_path.iterdir()) == [source]


def test_people_of_a_video_go_back_into_one_file(tmp_path, capsys):
    body = hp.Body.default()
    high = floating(standing(), body).rebased(body, "y")
    translation, rotations = high.in_file_axes()
    people = [
        Person(name, np.arange(4, 4 + len(high)), translation + np.array([x, 0, 0]), rotations)
        for name, x in (("3", 0.0), ("8", 1.5))
    ]
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(people))
    out = tmp_path / "fixed.pkl"
    assert main(["fix", str(source), "--out", str(out)]) == 0
    assert f"written: {out} (wham)" in capsys.readouterr().out
    found = pickle.loads(out.read_bytes())  # the test's own file
    assert list(found) == [3, 8]
    for who in people:
        own = found[int(who.name)]
        assert own["frame_ids"].tolist() == who.frames.tolist()
        lower = own["trans_world"] - who.hips()
        assert np.abs(lower - [0.0, -0.05, 0.0]).max() < 5e-3


def test_everybody_of_a_result_is_put_right(tmp_path, capsys):
    """In the bodies that they have, one file each; a name reads one of them, frames cut all."""
    body, tall = hp.Body.default(), hp.Body.default(stature=1.9)
    one = floating(standing(), body)
    other = floating(standing().grounded(tall, 0.003), tall)
    other = other.with_frames(other.translation + np.array([1.5, 0.0, 0.0]), other.rotations)
    source, out = tmp_path / "result.npz", tmp_path / "fixed.npz"
    hp.simulate([one, other], hp.Scene(), body=[body, tall]).save(source)
    assert main(["fix", str(source), "--out", str(out)]) == 0
    assert "floated by 5.0 cm" in capsys.readouterr().out
    for k, (asked, its) in enumerate(((one, body), (other, tall))):
        made = hp.Motion.load(tmp_path / f"fixed_{k + 1}.npz")
        assert np.abs(made.translation[:, :2] - asked.translation[:, :2]).max() < 5e-3
        assert abs(its.vertices(made)[..., 2].min()) < 5e-3
    arguments = ["--clip", "person1", "--frames", "4:24", "--result", str(tmp_path / "r.npz")]
    assert main(["fix", str(source), *arguments]) == 0
    again = hp.Result.load(tmp_path / "r.npz")
    assert (len(again.people), len(again)) == (1, 20)
    assert again.people[0].motion.translation[0, 0] > 1.4
    assert main(["fix", str(source), "--clip", "anne"]) == 2
    assert "found 'anne', expected one of" in capsys.readouterr().err
    for useless in (["--up", "y"], ["--fps", "25"], ["--hands", "mean"]):
        assert main(["fix", str(source), *useless]) == 2
        assert "a result has its own axes, rate and bodies" in capsys.readouterr().err


def test_outputs_have_a_file_each(clip, tmp_path, capsys):
    both = str(tmp_path / "same.npz")
    assert main(["fix", str(clip), "--out", both, "--result", both]) == 2
    assert "found one file for two of them" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [clip]


def test_numbered_files_are_no_other_output(tmp_path, capsys):
    one = standing()
    other = one.with_frames(one.translation + np.array([1.5, 0.0, 0.0]), one.rotations)
    source = tmp_path / "result.npz"
    hp.simulate([one, other], hp.Scene()).save(source)
    out, result = str(tmp_path / "fixed.npz"), str(tmp_path / "fixed_2.npz")
    assert main(["fix", str(source), "--out", out, "--result", result]) == 2
    assert "found one file for two of them" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [source]
