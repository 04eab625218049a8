"""hp.view and halfphysics view without a browser: address, ports, endings, mistakes."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from types import SimpleNamespace
from urllib.request import ProxyHandler, build_opener

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.address import url
from halfphysics.viewer.arrange import arrange
from halfphysics.viewer.controls import slider_end
from halfphysics.viewer.server import free_port
from halfphysics.viewer.view import Viewer, differences
from support.people import along_x
from support.results.small_result import small_result


def fetched(url):
    with build_opener(ProxyHandler({})).open(url, timeout=20.0) as answer:
        return answer.status, answer.read()


def walking_into_a_wall(stiffness):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("wall", hp.Box((0.1, 2.0, 2.0)), position=(0.6, 0.0, 1.0))
    settings = hp.Settings(stiffness=stiffness, contact="parts")
    return hp.simulate(along_x(1.0, 15, 0.0, z=1.2), scene, settings=settings)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    paths = []
    for stiffness in (0.0, 1.0):
        path = folder / f"soft{stiffness:g}.npz"
        walking_into_a_wall(stiffness).save(path)
        paths.append(path)
    return paths


def start(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "halfphysics", "view", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip


@pytest.mark.slow
def test_it_serves_says_where_and_ends_with_ctrl_c(files):
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        port = busy.getsockname()[1]
        process = start(*files, "--port", port)
        try:
            lines = [process.stdout.readline() for _ in range(4)]
            assert lines[0].startswith(f"port {port} is in use, taking ")
            taken = int(lines[0].split()[-1])
            assert taken > port
            assert lines[1] == (
                f"showing soft0, stiffness 0 and soft1, stiffness 1 at http://127.0.0.1:{taken}\n"
            )
            assert f"ssh -L {taken}:127.0.0.1:{taken}" in lines[2]
            assert "Ctrl-C" in lines[3]
            status, page = fetched(f"http://127.0.0.1:{taken}")
            assert status == 200
            assert b"<html" in page
        finally:
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=30)
        assert process.returncode == 130
        assert (out, err.strip()) == ("", "")
        with pytest.raises(OSError):
            fetched(f"http://127.0.0.1:{taken}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing.npz"], "nothing.npz: no such file"),
        ([], "found no file, expected at least one result or motion"),
        ([__file__], "test_view.py"),
        (["FILE", "--port", "99999"], "port: found 99999, expected a whole number from 0 to 65535"),
        (["FILE", "--host", "no.such.host.invalid"], "no address"),
        (["FILE", "--host", "192.0.2.1"], "no address of this machine"),
    ],
)
def test_mistakes_end_in_one_message(files, arguments, said, capfd):
    from halfphysics.cli import main

    assert main(["view", *(str(files[0]) if a == "FILE" else a for a in arguments)]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("halfphysics: error: ")
    assert said in err


def test_without_blocking_it_is_a_context_that_cleans_up(capfd):
    before = set(threading.enumerate())
    with hp.view(small_result(), block=False, port=0) as viewer:
        assert fetched(viewer.url)[0] == 200
        assert viewer.url.endswith(f":{viewer.port}")
        assert f'src="{viewer.url}"' in viewer._repr_html_()
        assert viewer.url in repr(viewer)
        assert viewer.timeline.playing
    viewer.stop()  # again, without effect
    assert "stopped" in repr(viewer)
    assert "iframe" not in viewer._repr_html_()
    out, err = capfd.readouterr()
    assert out.startswith("showing the result at http://127.0.0.1:")
    assert "in use" not in out  # port 0 takes any free port
    assert err == ""
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        left = [t for t in set(threading.enumerate()) - before if t.is_alive()]
        if not left:
            break
        time.sleep(0.1)
    assert left == []


def test_ctrl_c_before_it_waits_stops_it_and_is_passed_on(monkeypatch):
    made = []
    monkeypatch.setattr(Viewer, "wait", lambda self: (made.append(self), _interrupt()))

    def _interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hp.view(small_result(), port=0)
    assert "stopped" in repr(made[0])


def test_a_failure_while_playing_is_raised_where_it_waits(monkeypatch):
    viewer = hp.view(small_result(), block=False, port=0)

    def fails():
        raise RuntimeError("half-way")

    viewer.do(fails)
    with pytest.raises(RuntimeError, match="half-way"):
        viewer.wait()


def test_what_is_no_result_is_refused():
    with pytest.raises(InputError, match=r"result 2: found 'x\.npz'"):
        hp.view(small_result(), "x.npz", block=False)
    with pytest.raises(InputError, match="labels: found 1, expected 2"):
        hp.view(small_result(), small_result(), labels=["a"], block=False)


def test_ports():
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        port = busy.getsockname()[1]
        assert free_port("127.0.0.1", port) > port
    assert free_port("127.0.0.1", 0) == 0
    assert free_port("127.0.0.1", np.int64(0)) == 0
    with pytest.raises(InputError, match=r"host: found 3, expected an address"):
        free_port(3, 0)
    for wrong in (-1, 65536, 1.5, True, "8080"):
        with pytest.raises(InputError, match="port"):
            free_port("127.0.0.1", wrong)


def test_no_port_at_all(monkeypatch):
    from halfphysics.viewer import server

    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        monkeypatch.setattr(server, "TRIES", 1)
        with pytest.raises(FileError, match=r"in use\. Give another port"):
            free_port("127.0.0.1", busy.getsockname()[1])


def test_names_tell_results_apart(files):
    from pathlib import Path

    from halfphysics.cli.view import _names

    assert _names((Path("a/x.npz"), Path("a/y.npz"))) == ["x", "y"]
    assert _names((Path("a/x.npz"), Path("b/x.npz"))) == ["a/x", "b/x"]
    assert _names((Path("a/x.npz"), Path("a/x.npz"))) == ["x (1)", "x (2)"]
    results = [hp.Result.load(path) for path in files]
    assert differences(results) == [", stiffness 0", ", stiffness 1"]
    assert differences([results[0], results[0]]) == ["", ""]


def test_results_stand_side_by_side_and_all_are_in_the_picture():
    drawings = [Drawing(small_result()) for _ in range(3)]
    row = arrange(drawings, (1280, 720))
    assert (row.offsets[0] == 0.0).all()
    # No person is within another's reach, at any frame.
    tracks = [
        person.body.joints(motion)[:, 0] + offset
        for offset in row.offsets
        for person in drawings[0].result.people
        for motion in (person.motion, person.reference)
    ]
    for a in range(0, 6, 2):
        for b in range(a + 2, 6, 2):
            gaps = np.linalg.norm(tracks[a][:, None] - tracks[b][None], axis=-1)
            assert gaps.min() > 1.0
    # From left to right, and in the picture of a desktop and of a phone.
    for size in ((1280, 720), (390, 600)):
        camera = row.camera(size)
        forward = camera.target - camera.position
        right = np.cross(forward, [0.0, 0.0, 1.0])
        along = row.offsets @ (right / np.linalg.norm(right))
        assert (np.diff(along) > 0.5).all()


def test_a_short_and_a_slow_result_keep_time_together():
    quick = small_result()
    with Viewer([quick, quick], port=0) as viewer:
        viewer.timeline.pause()
        viewer.timeline.seek(0.2)
        assert viewer.timeline.frames() == (6, 6)
        assert viewer.labels == ("result 1", "result 2")
        assert [stage.prefix for stage in viewer.stages] == ["/0", "/1"]
        # One floor for both.
        assert viewer.stages[0].static("floor")
        with pytest.raises(KeyError):
            viewer.stages[1].static("floor")


@pytest.mark.parametrize(
    ("duration", "end"), [(401 / 30, 13.37), (13.36, 13.36), (0.0, 0.01), (0.004, 0.01)]
)
def test_the_slider_ends_with_a_whole_step_at_the_last_frame_or_just_after(duration, end):
    assert slider_end(duration) == end


def test_a_dropped_result_whose_mesh_is_damaged_leaves_the_scene_as_it_is(tmp_path):
    mesh = tmp_path / "crate.obj"
    trimesh.creation.box((0.4, 0.4, 0.4)).export(mesh)
    scene = hp.Scene()
    scene.add_static("crate", mesh, position=(3.0, 0.0, 0.2))
    hp.simulate(along_x(1.0, 3, 0.0, z=1.2), scene).save(tmp_path / "out.npz")
    mesh.write_text("nothing")
    done = threading.Event()
    with Viewer([small_result()], port=0) as viewer:
        before = viewer.stages

        def drop():
            viewer.take("out.npz", (tmp_path / "out.npz").read_bytes())
            done.set()

        viewer.do(drop)
        done.wait(10.0)
        assert viewer._failure is None
        assert viewer.controls.remote._told["say"].startswith("out.npz, statics.crate.mesh: ")
        assert viewer.stages is before


def test_values_that_no_slider_has_are_ignored():
    """Any browser can send them; they ended the viewer for all."""
    with Viewer([small_result()], port=0) as viewer:
        viewer.timeline.pause()
        viewer.timeline.seek(0.1)
        controls, before = viewer.controls, viewer.timeline.time
        for value in (np.nan, np.inf):
            controls._slider._impl.value = value
            controls._scrubbed(SimpleNamespace(client_id=1))
        for command in ("seek", "step", "speed"):
            for value in ("fast", None, np.nan, [1.0]):
                controls._obey(command, value, None)
        assert viewer.timeline.time == before
        assert viewer.timeline.speed == 1.0


def test_files_of_one_drop_are_shown_together(tmp_path, monkeypatch):
    for name in ("one", "two"):
        along_x(1.0, 31, 0.0, z=1.0).save(tmp_path / f"{name}.npz")
    with Viewer([small_result()], port=0) as viewer:
        scenes = []
        build = viewer._build
        monkeypatch.setattr(viewer, "_build", lambda *args: scenes.append(1) or build(*args))
        viewer._root.uploads = SimpleNamespace(under_way=True)
        for name in ("one", "two"):
            content = (tmp_path / f"{name}.npz").read_bytes()
            viewer.do(lambda name=name, content=content: viewer.take(f"{name}.npz", content))
            viewer.do(lambda: setattr(viewer._root.uploads, "under_way", len(viewer._added) < 2))
        end = time.monotonic() + 20.0
        while len(viewer.stages) < 3 and time.monotonic() < end:
            time.sleep(0.02)
        assert viewer.labels == ("first", "one", "two")
        assert len(scenes) == 1


def test_the_reference_moves_while_any_browser_compares():
    clients, switched = {1: None, 2: None}, []
    viewer = SimpleNamespace(
        _comparing=set(),
        server=SimpleNamespace(get_clients=lambda: clients),
        references=[SimpleNamespace(switch=switched.append)],
    )
    Viewer.compare(viewer, 1, True)
    Viewer.compare(viewer, 2, True)
    Viewer.compare(viewer, 1, False)
    assert switched == [True, True, True]
    del clients[2]  # it has gone without a word
    Viewer.compare(viewer, 1, False)
    assert switched[-1] is False


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "http://127.0.0.1:80"),
        ("0.0.0.0", "http://127.0.0.1:80"),
        ("::", "http://[::1]:80"),  # a socket of IPv6 alone
        ("::1", "http://[::1]:80"),
        ("desk.example", "http://desk.example:80"),
    ],
)
def test_the_address_that_is_printed_is_one_that_answers(host, address):
    assert url(host, 80) == address
