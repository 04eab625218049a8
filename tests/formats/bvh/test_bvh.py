"""BVH files: the text, the writer, and the files that every reader refuses."""

from __future__ import annotations

import dataclasses
import re
import time
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES, axes_of, turned
from halfphysics.cli import main
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.formats import FORMATS, Source, identify, losses
from halfphysics.formats.bvh.text import Bvh, read_bvh, write_bvh
from halfphysics.motion import skeleton
from support.files.bvh_files import MIXAMO, read_places, retold, smplx
from support.files.layouts import movement
from support.files.wrong_files import refused

SAME = 1e-6  # metres: files have 1e-9 of a centimetre or degree
FPS = 30.0


def motion_of(frames: int = 12, up: str = "z", seed: int = 0) -> hp.Motion:
    translation, rotations = movement(frames, seed)
    if up == "y":
        body = hp.Body.default()
        motion = hp.Motion(translation, rotations, FPS).rebased(body, "y")
        assert np.array_equal(motion.axes, axes_of("y"))
        return motion
    return hp.Motion(translation, rotations, FPS)


def read(path, **options) -> hp.Motion:
    """Read without the warning about the skeleton."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return hp.Motion.load(path, **options)


@pytest.mark.parametrize("up", ["z", "y"])
@pytest.mark.parametrize("stature", [None, 1.2])
def test_written_and_read_the_same(tmp_path, up, stature):
    body, motion = hp.Body.default(stature=stature), motion_of(up=up)
    motion.save(tmp_path / "a.bvh", body=body)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = hp.Motion.load(tmp_path / "a.bvh")
    assert again.fps == FPS
    assert np.abs(body.vertices(again) - body.vertices(motion)).max() < SAME
    again.save(tmp_path / "b.bvh", body=body)
    assert np.abs(body.vertices(read(tmp_path / "b.bvh")) - body.vertices(motion)).max() < SAME


def test_turned_resampled_and_grounded_is_written_too(tmp_path):
    body, motion = hp.Body.default(), motion_of(30)
    half = np.array([0.0, 0.0, 1.2])
    turn = rot.rotvec_to_matrix(half)
    translation, rotations = turned(motion.translation, motion.rotations, turn)
    motion = motion.with_frames(translation, rotations).resample(47.5).grounded(body)
    motion.save(tmp_path / "a.bvh", body=body)
    again = read(tmp_path / "a.bvh")
    assert again.fps == pytest.approx(47.5, rel=1e-12)
    assert np.abs(body.vertices(again) - body.vertices(motion)).max() < SAME


def test_an_independent_reader_has_the_same_joints(tmp_path):
    body, motion = hp.Body.default(), motion_of(30)
    motion.save(tmp_path / "a.bvh", body=body)
    places, seconds = read_places(tmp_path / "a.bvh")
    assert seconds == 1.0 / FPS
    ours = body.joints(motion) @ AXES["y"]  # y-up
    assert np.abs(smplx(places) / 100.0 - ours).max() < SAME


def test_bvhio_has_the_same_joints(tmp_path):
    bvhio = pytest.importorskip("bvhio")
    body, motion = hp.Body.default(), motion_of(30)
    motion.save(tmp_path / "a.bvh", body=body)
    ours = body.joints(motion) @ AXES["y"]
    root = bvhio.readAsHierarchy(str(tmp_path / "a.bvh"))
    for frame in (0, 7, 29):
        root.loadPose(frame)
        places = {joint.Name: np.array(joint.PositionWorld) for joint, _, _ in root.layout()}
        # bvhio computes in single precision: it is accurate to 1e-6 m.
        theirs = np.stack([places[name] for name in skeleton.JOINT_NAMES]) / 100.0
        assert np.abs(theirs - ours[frame]).max() < SAME


def test_the_skeleton_at_rest_is_the_body_at_rest(tmp_path):
    body = hp.Body.default(stature=1.5)
    motion_of().save(tmp_path / "a.bvh", body=body)
    bvh = read_bvh(tmp_path / "a.bvh")
    rest = np.zeros((56, 3))
    for joint in range(1, 56):
        rest[joint] = rest[bvh.parents[joint]] + bvh.offsets[joint] / 100.0
    order = [bvh.names.index(name) for name in skeleton.JOINT_NAMES]
    assert np.abs(rest[order] - body.rest_joints).max() < SAME
    assert np.array_equal(bvh.offsets[0], np.zeros(3))  # readers disagree on a root's offset
    leaves = set(range(56)) - {p for p in bvh.parents if p >= 0}
    assert set(bvh.ends) == leaves


#: Rest poses in other axes than SMPL-X's: z up, to the side, upside down, and no axes at all.
TURNS = ([np.pi / 2, 0, 0], [0, np.pi / 2, 0], [0, 0, np.pi], [0.9, -1.1, 0.5])


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("stature", [None, 1.2])
def test_a_rest_pose_in_other_axes(tmp_path, turn, stature):
    """Offsets and joint frames are turned against SMPL-X's, the movement is the same."""
    body, motion = hp.Body.default(stature=stature), motion_of(16)
    names = dict(enumerate(skeleton.JOINT_NAMES))
    own = np.tile(rot.conjugate(rot.exp(np.array(turn, dtype=float))), (55, 1))
    for name, frames in (("as_it_is", None), ("turned", own)):
        text = retold(motion, body, names=names, own=frames)
        (tmp_path / f"{name}.bvh").write_text(text)
    with pytest.warns(HalfPhysicsWarning, match=r"turned by \d+ degrees: turned back; y up"):
        found = hp.Motion.load(tmp_path / "turned.bvh")
    expected = read(tmp_path / "as_it_is.bvh")
    assert np.abs(body.vertices(found) - body.vertices(expected)).max() < SAME


@pytest.mark.parametrize("options", [{}, {"up": "z"}])
def test_a_file_of_ours_that_blender_has_written_again(tmp_path, options):
    """Blender's export has z up: all of the file is turned, the pelvis below the root too."""
    body, motion = hp.Body.default(stature=1.2), motion_of(16)
    motion.save(tmp_path / "a.bvh", body=body)
    write_bvh(tmp_path / "b.bvh", z_up(read_bvh(tmp_path / "a.bvh")))
    found = read(tmp_path / "b.bvh", **options)
    assert np.abs(body.vertices(found) - body.vertices(motion)).max() < SAME


def z_up(bvh: Bvh) -> Bvh:
    """A file with y up in axes with z up."""
    values, column = bvh.values.copy(), 0
    turn = Rotation.from_matrix(AXES["y"])
    for channels in bvh.channels:
        for kind in ("position", "rotation"):
            names = [name for name in channels if name.endswith(kind)]
            columns = [column + channels.index(name) for name in names]
            order = "".join(name[0] for name in names)
            if kind == "position" and names:
                values[:, columns] = turn.apply(values[:, columns])
            elif names:
                own = turn * Rotation.from_euler(order, values[:, columns], True) * turn.inv()
                values[:, columns] = own.as_euler(order, degrees=True)
        column += len(channels)
    ends = {joint: turn.apply(end) for joint, end in bvh.ends.items()}
    return dataclasses.replace(bvh, offsets=turn.apply(bvh.offsets), ends=ends, values=values)


def test_angles_are_continuous(tmp_path):
    """Two whole turns and swings through gimbal lock, without a jump of the written angles."""
    frames, body = 400, hp.Body.default()
    t = np.linspace(0.0, 1.0, frames)
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0, 2] = 4.0 * np.pi * t
    rotations[:, 18, 1] = -2.4 * t
    rotations[:, 4, 0] = np.pi / 2 + 1e-9 * np.sin(9 * t)
    rotations[:, 5] = np.outer(2.0 * t, [0.6, 0.8, 0.0])
    motion = hp.Motion(np.zeros((frames, 3)), rotations, 60.0)
    motion.save(tmp_path / "a.bvh", body=body)
    values = read_bvh(tmp_path / "a.bvh").values
    assert np.abs(np.diff(values, axis=0)).max() < 5.0  # degrees per frame
    assert np.ptp(values[:, 6:9], axis=0).max() == pytest.approx(720.0, abs=1e-6)
    again, some = read(tmp_path / "a.bvh"), slice(None, None, 9)
    assert np.abs(body.vertices(again, some) - body.vertices(motion, some)).max() < SAME


def test_angles_of_a_wild_dance_change_no_faster_than_the_joints(tmp_path, shared_data):
    body, motion = hp.Body.default(), read(shared_data / "motion" / "animdraw_jesse_dance.bvh")
    motion.save(tmp_path / "a.bvh", body=body)
    turns = rot.exp(motion.rotations)
    step = rot.multiply(rot.conjugate(turns[:-1]), turns[1:])
    fastest = np.degrees(np.linalg.norm(rot.log(step), axis=-1).max())
    assert np.abs(np.diff(read_bvh(tmp_path / "a.bvh").values, axis=0)).max() < 1.5 * fastest


def test_convert_there_and_back(tmp_path, capsys):
    """Without a body argument the default body is used."""
    body, motion = hp.Body.default(), motion_of()
    motion.save(tmp_path / "a.npz")
    assert main(["convert", str(tmp_path / "a.npz"), str(tmp_path / "b.bvh")]) == 0
    again = read(tmp_path / "b.bvh")
    assert np.abs(body.vertices(again) - body.vertices(motion)).max() < SAME
    (tmp_path / "c.bvh").write_text(retold(motion, body))
    assert main(["convert", str(tmp_path / "c.bvh"), str(tmp_path / "d.npz")]) == 0
    assert "put on the default body" in capsys.readouterr().err
    expected = body.vertices(read(tmp_path / "c.bvh"))
    assert np.abs(body.vertices(hp.Motion.load(tmp_path / "d.npz")) - expected).max() < SAME


def test_what_it_cannot_hold_is_said(tmp_path):
    translation, rotations = movement()
    motion = hp.Motion(translation, rotations, FPS, betas=np.ones(3), gender="male", model="smplh")
    assert losses(motion, tmp_path / "a.bvh") == [
        "the shape (betas): the joints of the body are written, its skin is not",
        "the gender 'male'",
        "the model 'smplh': read back as smplx",
    ]
    assert losses(motion_of(), tmp_path / "a.bvh") == []
    with pytest.raises(InputError, match="body="):
        motion.save(tmp_path / "a.bvh")
    assert not (tmp_path / "a.bvh").exists()


def test_it_is_found_by_content_alone(tmp_path):
    text = retold(motion_of(), hp.Body.default())
    for name, start in (("walk.txt", ""), ("noname", "\ufeff"), ("a.npz", " \n\t\n")):
        (tmp_path / name).write_text(start + text, encoding="utf-8")
        found = identify(Source(tmp_path / name))
        assert found is FORMATS["bvh"]
        assert len(read(tmp_path / name)) == 12


def test_the_text_may_be_laid_out_in_any_way(tmp_path):
    """Windows lines, keywords in any case, braces on the line, orders by joint, all places."""
    body, motion = hp.Body.default(), motion_of()
    (tmp_path / "a.bvh").write_text(retold(motion, body))
    expected = body.vertices(read(tmp_path / "a.bvh"))
    orders = ["XYZ", "ZYX", "YXZ", "XZY", "YZX", "ZXY"] * 9
    others = {
        "orders": retold(motion, body, order=orders[: len(MIXAMO)]),
        "places": retold(motion, body, places=True),
    }
    plain = retold(motion, body)
    others["windows"] = plain.replace("\n", "\r\n")
    others["mac"] = plain.replace("\n", "\r")
    others["case"] = plain.replace("CHANNELS", "Channels").replace("position", "POSITION")
    others["braces"] = plain.replace("Hips\n{", "Hips {").replace("JOINT", "Joint")
    others["blanks"] = plain.replace("\n", " \n\n") + "\n\n  \n"
    others["no last newline"] = plain.rstrip("\n")
    for name, text in others.items():
        (tmp_path / "b.bvh").write_text(text, newline="")
        assert np.abs(body.vertices(read(tmp_path / "b.bvh")) - expected).max() < SAME, name


@pytest.mark.parametrize(
    ("said", "fps"),
    [
        ("0.0333333", 30.0),
        (".03333", 30.0),
        ("0.03333333", 30.0),
        ("0.00833333", 120.0),
        ("0.01666667", 60.0),
        ("0.04166667", 24.0),
        ("0.0111111", 90.0),
        ("0.08", 12.5),
        ("0.008333", 120.0),
        ("0.00833333333333", 120.0),
        ("0.008342", 120.0 / 1.001),
        ("0.0333667", 30.0 / 1.001),
        ("1.0e-2", 100.0),
        ("0.04", 25.0),
        ("0.0224719101123596", 44.5),
        ("0.017", 60.0),
        ("0.03", 30.0),
        ("0.0417", 24.0),
        ("0.0417083", 24.0 / 1.001),
        ("0.016949", 59.0),
        ("0.0333", 30.0),
    ],
)
def test_frame_time_that_was_rounded_is_the_rate_that_was_meant(tmp_path, said, fps):
    (tmp_path / "a.bvh").write_text(retold(motion_of(), hp.Body.default(), frame_time=said))
    assert read(tmp_path / "a.bvh").fps == pytest.approx(fps, rel=1e-12)


def test_frames_are_cut(tmp_path):
    body = hp.Body.default()
    motion_of().save(tmp_path / "a.bvh", body=body)
    part, whole = read(tmp_path / "a.bvh", frames=(3, 9)), read(tmp_path / "a.bvh")
    assert np.array_equal(part.rotations, whole.rotations[3:9])
    assert np.array_equal(part.translation, whole.translation[3:9])


def swap(old: str, new: str, count: int = 1):
    def spoil(text: str) -> str:
        assert old in text
        return text.replace(old, new, count)

    return spoil


def row(number: int, how):
    """A changed row of numbers: `how` of its words."""

    def spoil(text: str) -> str:
        lines = text.rstrip("\n").split("\n")
        first = next(i for i, line in enumerate(lines) if line.startswith("Frame Time")) + 1
        lines[first + number] = " ".join(how(lines[first + number].split()))
        return "\n".join(lines) + "\n"

    return spoil


def put(index: int, word: str):
    return lambda words: [*words[:index], word, *words[index + 1 :]]


WRONG = [
    ("skeleton only", lambda t: t[: t.index("MOTION")], r"line \d+.*without MOTION"),
    ("no ROOT", swap("ROOT Hips", "JOINT Hips"), "line 2.*expected ROOT"),
    ("two roots", swap("JOINT LeftUpLeg", "ROOT LeftUpLeg"), "second ROOT"),
    ("two skeletons", swap("MOTION", "ROOT Other\nMOTION"), "one skeleton per file"),
    ("joint without a name", swap("JOINT Neck", "JOINT"), r"line \d+.*without a name"),
    ("a name twice", swap("JOINT Neck", "JOINT Hips"), "'Hips' a second time"),
    ("no brace", swap("ROOT Hips\n{", "ROOT Hips\n"), r"line 4.*expected '{'"),
    ("unclosed", swap("}\nMOTION", "MOTION"), "file ends here"),
    ("closed twice", swap("}\nMOTION", "}\n}\nMOTION"), "after the joints"),
    ("no offset", swap("OFFSET", "OFSET"), "line 4.*expected OFFSET"),
    ("offset of two", swap("OFFSET 0.000000000000", "OFFSET"), "three numbers"),
    ("offset of words", swap("OFFSET 0.000000000000", "OFFSET x"), "three numbers"),
    ("offset NaN", swap("OFFSET 0.000000000000", "OFFSET nan"), "three numbers"),
    ("offset of no person", swap("OFFSET 0.000000000000", "OFFSET 1e12"), "under 1e[+]09"),
    ("a number of no person", row(3, put(2, "1e300")), r"line \d+: number 3.*under 1e[+]09"),
    ("no channels", swap("CHANNELS 3", "CANALS 3"), "expected CHANNELS"),
    ("channels uncounted", swap("CHANNELS 3 ", "CHANNELS "), "expected CHANNELS, their number"),
    ("too few channels", swap("CHANNELS 3 Z", "CHANNELS 4 Z"), "3 channels.*expected the 4"),
    ("channels beyond numbers", swap("CHANNELS 3", "CHANNELS " + 5000 * "9"), "expected CHANNELS"),
    ("frames beyond numbers", swap("Frames: 12", "Frames: " + 5000 * "9"), "'Frames: 120'"),
    ("unknown channel", swap("Zrotation", "Wrotation"), "'Wrotation'.*expected some of"),
    ("a channel twice", swap("Zrotation Xrotation", "Zrotation Zrotation"), "each channel once"),
    ("no frame count", swap("Frames: 12\n", ""), "'Frames: 120'"),
    ("negative frames", swap("Frames: 12", "Frames: -12"), "'Frames: 120'"),
    ("too many frames", swap("Frames: 12", "Frames: 13"), "after 12 rows.*expected the 13"),
    ("too few frames", swap("Frames: 12", "Frames: 11"), "after 12 rows.*expected the 11"),
    ("no frame time", swap("Frame Time: 0.0333333\n", ""), "'Frame Time: 0.0333333'"),
    ("frame time zero", swap("0.0333333", "0.0"), "seconds above zero"),
    ("frame time negative", swap("0.0333333", "-0.0333333"), "seconds above zero"),
    ("frame time of text", swap("0.0333333", "fast"), "seconds above zero"),
    ("frame time NaN", swap("0.0333333", "nan"), "seconds above zero"),
    ("frame time tiny", swap("0.0333333", "1e-320"), "seconds above zero"),
    ("frame time huge exponent", swap("0.0333333", "1e-99999"), "seconds above zero"),
    ("a short row", row(4, lambda w: w[:-1]), r"line \d+.*found 158 numbers.*expected 159"),
    ("a long row", row(4, lambda w: [*w, "0"]), r"line \d+.*found 160 numbers.*expected 159"),
    ("a word", row(5, put(7, "abc")), r"line \d+: word 8.*'abc'.*numbers"),
    ("an underscore", row(5, put(7, "1_0")), r"line \d+: word 8.*'1_0'"),
    ("NaN", row(3, put(2, "nan")), r"line \d+: number 3.*nan.*finite"),
    ("infinite", row(3, put(2, "-inf")), r"line \d+: number 3.*-inf.*finite"),
    ("a jump", row(3, put(0, "1e7")), "m/s between frames"),
    ("no legs", lambda t: t.replace("UpLeg", "Wheel"), "left_knee.*Found joints Hips"),
    ("no arms", lambda t: t.replace("ForeArm", "Gripper"), "left_elbow, right_elbow"),
    ("no length", lambda t: re.sub(r"OFFSET .*", "OFFSET 0 0 0", t), "left_hip.*no length"),
    ("binary inside", swap("JOINT Neck", "\x00\x01\x02"), r"line \d+: found"),
    ("statements of nothing", swap("JOINT Neck", "PELICAN Neck"), "expected JOINT, End Site"),
    ("no End Site block", swap("End Site\n", "End Site {\n", 1), "expected OFFSET"),
]


@pytest.fixture(scope="module")
def good() -> str:
    return retold(motion_of(), hp.Body.default())


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, good, spoil, message):
    bad = spoil(good)
    assert bad != good
    (tmp_path / "bad.bvh").write_text(bad)
    refused(tmp_path / "bad.bvh", message)


def test_one_frame_and_options_that_do_not_fit(tmp_path, good):
    path = tmp_path / "a.bvh"
    path.write_text(good)
    with pytest.raises(InputError, match=r"a.bvh has 12 frames"):
        read(path, frames=(0, 1))
    with pytest.raises(InputError, match=r"a.bvh has 12 frames"):
        read(path, frames=(5, 5))
    with pytest.raises(InputError, match=r"a.bvh holds one motion only"):
        read(path, clip="walk")


def test_truncated_anywhere_is_an_error_of_ours(tmp_path, good):
    """A cut within the last number cannot be detected; every other cut is."""
    path = tmp_path / "a.bvh"
    last = len(good) - len(good.rstrip("\n").split(" ")[-1]) - 2
    for length in np.linspace(1, last, 60).astype(int):
        path.write_text(good[:length])
        with pytest.raises(HalfPhysicsError, match=r"a\.bvh"):
            read(path)


def test_flipped_bytes_are_errors_of_ours_or_harmless(tmp_path, good):
    path, rng = tmp_path / "a.bvh", np.random.default_rng(0)
    for _ in range(60):
        bad = bytearray(good.encode())
        bad[rng.integers(len(bad))] ^= 1 << rng.integers(8)
        path.write_bytes(bytes(bad))
        try:
            read(path)
        except HalfPhysicsError:
            continue


def test_a_thousand_frames_of_sixty_joints_load_at_once(shared_data):
    path = shared_data / "motion" / "animdraw_jesse_dance.bvh"
    read(path)
    start = time.process_time()
    assert len(read(path)) == 1007
    assert time.process_time() - start < 0.6  # measured: 0.08 s


@pytest.mark.parametrize("fps", [29.97, 59.94, 23.976, 30.0, 119.88, 12.5])
def test_a_rate_of_few_digits_comes_back_as_it_was(tmp_path, fps):
    motion = hp.Motion(*movement(4), fps)
    for name in ("a.bvh", "a.smpl"):
        motion.save(tmp_path / name, body=hp.Body.default())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HalfPhysicsWarning)
            assert hp.Motion.load(tmp_path / name).fps == fps
