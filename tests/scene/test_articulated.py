"""Doors, drawers and other articulated objects in scenes: their motion and their limits."""

import mujoco
import numpy as np
import pytest
import trimesh

from halfphysics import Box, Plane, Scene, Settings, Simulator, Sphere, simulate
from halfphysics.base import limited_child
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Mesh
from halfphysics.metrics import penetration
from halfphysics.results.records import SceneRecord
from halfphysics.results.result import Result
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scene.changed import changed
from support.doors import ACROSS, DOOR
from support.judges.coal_scene import Watch
from support.people import along_x

CABINET = """<mujoco><worldbody>
<geom name="case" type="box" pos=".3 0 .4" size=".02 .3 .4"/>
<body name="drawer" pos="0 0 1.0"><joint name="rail" type="slide" axis="1 0 0" range="-.4 0"/>
<geom type="box" pos=".12 0 0" size=".15 .2 .08" mass="4"/></body></worldbody></mujoco>"""


URDF = """<robot name="lid">
<link name="base"><collision><geometry><box size=".3 .2 .02"/></geometry></collision></link>
<link name="screen">{inertial}
<collision><origin xyz="0 .1 0"/><geometry><box size=".3 .2 .01"/></geometry></collision></link>
<joint name="lid" type="revolute"><parent link="base"/><child link="screen"/>
<origin xyz="0 -.1 .02"/><axis xyz="1 0 0"/><limit lower="0" upper="2.2" effort="1" velocity="1"/>
<dynamics damping="0.02"/></joint></robot>"""
INERTIAL = """<inertial><origin xyz="0 .1 0"/><mass value=".8"/>
<inertia ixx=".003" iyy=".006" izz=".009" ixy="0" ixz="0" iyz="0"/></inertial>"""


@pytest.fixture(scope="module")
def body():
    return Body.default()


def alone(scene, frames, fps=60.0, **settings):
    """Objects without people: (frames + 1) values of every joint and poses of every link."""
    simulator = Simulator(scene, body=[], settings=Settings(**settings), fps=fps)
    got = [simulator.reset([])]
    got += [simulator.step([]) for _ in range(frames)]
    return simulator, got


def test_a_walking_person_opens_a_door(body):
    scene = Scene()
    scene.add_static("floor", Plane())
    door = scene.add_articulated("door", DOOR, **ACROSS)
    motion = walk(body, Walk(distance=2.0))
    simulator = Simulator(scene, body=body, settings=Settings(contact="parts"), fps=motion.fps)
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, len(motion))]
    angle = np.array([f.joints["door/hinge"] for f in frames])
    hinge = door.links[1].joints[0]
    assert angle.max() > np.deg2rad(80.0)
    assert (angle >= hinge.lower).all()
    assert (angle <= hinge.upper).all()
    # It moves about its hinge alone, and the person meets the panel under its own name.
    for f in frames:
        position, quat = f.objects["door/panel"]
        np.testing.assert_allclose(position, ACROSS["position"], atol=1e-12)
        turn = rot.multiply(ACROSS["quaternion"], rot.exp([0, 0, f.joints["door/hinge"]]))
        np.testing.assert_allclose(rot.to_matrix(quat), rot.to_matrix(turn), atol=1e-12)
    met = {simulator.names[n] for f in frames for n in f.contacts.other}
    assert "door/panel" in met
    watch = Watch(simulator)
    gaps = [watch.gap(f._qpos)[0] for f in frames[::4]]
    assert 0.0 < min(gaps) < 0.002  # the person pushes it


def test_a_text_is_compiled_once_and_what_names_files_every_time(monkeypatch, tmp_path):
    """Scenes of scenarios and sweeps have the same texts: a process starts half a second."""
    starts, run = [], limited_child.run

    def counted(*arguments, **options):
        starts.append(arguments)
        return run(*arguments, **options)

    monkeypatch.setattr(limited_child, "run", counted)
    own = CABINET.replace('mass="4"', 'mass="4.25"')  # no other test has it
    first, again = (Scene().add_articulated("box", own) for _ in range(2))
    assert len(starts) == 1
    assert first.links[1].mass == again.links[1].mass == 4.25
    lid = Scene().add_articulated("other", own, joints={"rail": -0.2})
    assert (len(starts), lid.joints, again.joints) == (1, {"rail": -0.2}, {})
    for mass in (2.0, 3.0):  # a file may have changed
        path = tmp_path / "box.xml"
        path.write_text(CABINET.replace('mass="4"', f'mass="{mass}"'))
        assert Scene().add_articulated("box", path).links[1].mass == mass
    assert len(starts) == 3


def test_a_body_pushes_a_drawer_shut(body):
    """The person stops where the drawer stops."""
    scene = Scene()
    scene.add_articulated("box", CABINET, position=(1.1, -0.4, 0.2), joints={"rail": -0.3})
    result = simulate(along_x(0.5, 60, 0.0, z=1.2), scene, body=body)
    rail = result.joints["box/rail"]
    assert rail[0] == -0.3
    assert rail.max() <= 0.0
    np.testing.assert_allclose(rail[-1], 0.0, atol=1e-6)
    track = result.objects["box/drawer"]
    np.testing.assert_allclose(track.position[:, 0], 1.1 + rail, atol=1e-12)
    np.testing.assert_allclose(track.position[:, 1:], [[-0.4, 1.2]] * len(rail), atol=1e-12)
    assert result.clearance.min() > 0.0  # from the case, which has no joint
    assert result.names == ("box/world", "box/drawer", "person")


def test_a_ball_opens_a_door_and_their_angular_momentum_stays():
    """About the hinge, without damping, friction or weight: the door gains the ball's loss."""
    scene = Scene(gravity=0.0)
    scene.add_articulated("door", DOOR.replace('damping="0.5"', ""), friction=0.0)
    radius, mass, speed = 0.1, 2.0, 3.0
    scene.add_object(
        "ball", Sphere(radius), mass=mass, position=(0.6, -0.5, 1.0), velocity=(0, speed, 0)
    )
    simulator, frames = alone(scene, 20)
    panel = scene.articulated["door"].links[1]
    axis = panel.mass * panel.com[:2] @ panel.com[:2]
    turn = rot.to_matrix(panel.inertia_quaternion)
    about = axis + (turn @ np.diag(panel.inertia) @ turn.T)[2, 2]
    velocity = simulator.world.stepper.qvel()
    ball, hinge = simulator.world.objects[0], simulator.world.joints[0]
    at = frames[-1].objects["ball"][0]
    v = velocity[ball.dof : ball.dof + 3]
    spin = 0.4 * mass * radius**2 * velocity[ball.dof + 5]  # it has hardly turned
    now = about * velocity[hinge.dof] + mass * (at[0] * v[1] - at[1] * v[0]) + spin
    assert velocity[hinge.dof] > 0.1
    np.testing.assert_allclose(now, mass * 0.6 * speed, rtol=1e-9)
    # An impact without rebound at an arm of 0.6: at first both move on together.
    first = next(k for k, f in enumerate(frames) if len(f.contacts.part))
    np.testing.assert_allclose(
        np.diff([f.joints["door/hinge"] for f in frames])[first + 1] * 60.0,
        mass * 0.6 * speed / (about + mass * 0.36),
        rtol=0.05,
    )


def test_links_are_where_the_core_has_them():
    scene = Scene()
    scene.add_object("box", Box([0.1, 0.2, 0.3]), mass=1.0)
    scene.add_articulated("lid", URDF.format(inertial=INERTIAL), position=(1, 2, 3))
    scene.add_articulated("door", DOOR, **ACROSS)
    world = Simulator(scene, body=[]).world
    rng = np.random.default_rng(1)
    qpos = rng.normal(size=world.nq)
    qpos[3:7] /= np.linalg.norm(qpos[3:7])
    position, quat = world.stepper.body_frames(qpos)
    for thing in scene.articulated.values():
        for i, name in enumerate(thing.link_names):
            place = next(link for link in world.links if link.name == name)
            b = world.model.body(f"articulated/{thing.name}/{i}").id
            got, turned = place.pose(qpos)
            np.testing.assert_allclose(got, position[b], atol=1e-12)
            np.testing.assert_allclose(rot.to_matrix(turned), rot.to_matrix(quat[b]), atol=1e-12)


def test_a_lid_falls_shut_and_stays():
    scene = Scene()
    scene.add_articulated("lid", URDF.format(inertial=INERTIAL), joints={"lid": 1.2})
    _, frames = alone(scene, 120)
    angle = np.array([f.joints["lid/lid"] for f in frames])
    assert angle[0] == 1.2
    assert angle.min() >= 0.0
    np.testing.assert_allclose(angle[-30:], 0.0, atol=1e-6)


def test_a_spec_gives_what_its_text_gives():
    text, made = Scene(), Scene()
    text.add_articulated("door", DOOR, velocities={"hinge": 1.0})
    made.add_articulated("door", mujoco.MjSpec.from_string(DOOR), velocities={"hinge": 1.0})
    angles = [[f.joints["door/hinge"] for f in alone(s, 30)[1]] for s in (text, made)]
    assert angles[0] == angles[1]
    assert angles[0][-1] > 0.1


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_scene_and_result_files(body, tmp_path, suffix):
    (tmp_path / "lid.urdf").write_text(URDF.format(inertial=INERTIAL))
    scene = Scene()
    scene.add_articulated("door", DOOR, joints={"hinge": 0.3}, **ACROSS)
    scene.add_articulated("lid", tmp_path / "lid.urdf", position=(3, 0, 0), friction=0.3)
    scene.save(tmp_path / f"scene{suffix}")
    again = Scene.load(tmp_path / f"scene{suffix}")
    results = [simulate(along_x(1.0, 8, 0.0), s, body=body) for s in (scene, again)]
    results[0].save(tmp_path / "result.npz")
    results.append(Result.load(tmp_path / "result.npz"))
    for other in results[1:]:
        for name, values in results[0].joints.items():
            assert (other.joints[name] == values).all()
        for name, track in results[0].objects.items():
            assert (other.objects[name].position == track.position).all()
            assert (other.objects[name].quaternion == track.quaternion).all()
    assert results[2].scene.articulated["lid"].friction == 0.3
    assert "door/panel" in results[2].summary()


@pytest.mark.parametrize(
    ("source", "options", "words"),
    [
        (DOOR, {"joints": {"hing": 0.1}}, "no joint 'hing'"),
        (DOOR, {"joints": {"hinge": 3.0}}, "expected -0.08"),
        (DOOR, {"velocities": {"hinge": "fast"}}, "expected a number"),
        (URDF.format(inertial=""), {}, "no <inertial>"),
        ("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>", {}, "no joints"),
        (DOOR.replace('"sphere"', '"plane"'), {}, "plane"),
        ("<scene/>", {}, "found <scene>"),
        (
            '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm side="left"/></robot>',
            {},
            "found <xacro:arm>.*expand it",
        ),
        ("<mujoco", {}, "not XML"),
        ('<mujoco><include file="a.xml"/></mujoco>', {}, "no folder"),
        ("<!DOCTYPE a><mujoco/>", {}, "entities"),
        (DOOR.replace("hinge", "hinge2", 1).replace("axis=", "axes="), {}, "cannot read"),
        (3, {}, "expected the path"),
    ],
)
def test_what_cannot_be_used_is_said(source, options, words):
    with pytest.raises(InputError, match=words):
        Scene().add_articulated("thing", source, **options)


def test_files_stay_in_their_folder(tmp_path):
    inside = tmp_path / "model"
    inside.mkdir()
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    path = inside / "door.xml"
    path.write_text('<mujoco><include file="../secret.xml"/></mujoco>')
    with pytest.raises(InputError, match="leaves the folder"):
        Scene().add_articulated("door", path)
    path.write_text('<mujoco><include file="gone.xml"/></mujoco>')
    with pytest.raises(FileError, match="not there"):
        Scene().add_articulated("door", path)
    with pytest.raises(FileError, match="no such file"):
        Scene().add_articulated("door", tmp_path / "none.urdf")
    text = DOOR.replace("<worldbody>", '<asset><mesh file="no.stl"/></asset><worldbody>')
    path.write_text(text)
    with pytest.raises(InputError, match=r"no\.stl"):
        Scene().add_articulated("door", path)


def test_what_plays_no_part_is_said():
    more = '<actuator><motor joint="hinge"/></actuator></mujoco>'
    with pytest.warns(HalfPhysicsWarning, match="1 actuators ignored"):
        Scene().add_articulated("door", DOOR.replace("</mujoco>", more))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('<keyframe><key qpos="0.3"/></keyframe>', "1 keyframes ignored"),
        ('<equality><joint joint1="hinge"/></equality>', r"1 equality .*mimic joints\) ignored"),
        ('<worldbody><body mocap="true"/></worldbody>', "1 mocap bodies, which stand still"),
        ('<option gravity="0 0 -1.62"/>', r"gravity \(0\.0, 0\.0, -1\.62\) m/s\^2 ignored"),
    ],
)
def test_what_a_file_says_of_its_world_is_said_to_be_ignored(more, said):
    text = DOOR.replace("</mujoco>", f"{more}</mujoco>")
    with pytest.warns(HalfPhysicsWarning, match=said):
        Scene().add_articulated("door", text)
    as_usual = DOOR.replace("</mujoco>", '<option gravity="0 0 -9.8"/></mujoco>')
    Scene().add_articulated("door", as_usual)  # warnings of ours are errors in tests


def test_names_and_pairs():
    scene = Scene()
    scene.add_articulated("door", DOOR)
    with pytest.raises(InputError, match="of this name already"):
        scene.add_object("door", Sphere(0.1), mass=1.0)
    scene.friction("door", "person", 0.2)
    assert scene.friction_of("person", "door") == 0.2
    assert scene.restitution_of("person", "door") == 0.0
    scene.ignore("door", "person")
    assert scene.ignores("door", "person")


def test_scissors_fall_and_come_to_rest():
    """A free body with a joint: lands, stays within its range, and stops."""
    xml = """<mujoco><worldbody><body name="one" pos="0 0 .3"><freejoint/>
    <geom type="box" size=".1 .01 .004" mass=".05"/>
    <body name="two" pos="0 0 .01"><joint name="rivet" axis="0 0 1" range="0 60" damping="1e-3"/>
    <geom type="box" size=".1 .01 .004" mass=".05"/></body></body></worldbody></mujoco>"""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_articulated("scissors", xml, joints={"rivet": 0.5}, velocities={"rivet": 2.0})
    simulator, frames = alone(scene, 120)
    angle = np.array([f.joints["scissors/rivet"] for f in frames])
    assert angle.min() >= 0.0
    assert angle.max() <= np.deg2rad(60.0)
    height = np.array([f.objects["scissors/one"][0][2] for f in frames])
    # In free fall each step h goes with the velocity at its end: g t (t + h) / 2.
    t, h = np.arange(12) / 60.0, 1 / 60.0 / Settings().substeps_for(1 / 60.0)
    np.testing.assert_allclose(height[:12], 0.3 - 4.905 * t * (t + h), atol=1e-9)
    np.testing.assert_allclose(height[-20:], 0.004 + 1e-3, atol=5e-4)
    assert np.abs(simulator.world.stepper.qvel()).max() < 0.02


def test_penetration_counts_links(body):
    """A person stands in a door."""
    scene = Scene()
    scene.add_articulated("door", DOOR, position=(-0.45, -0.4, 0.0))
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(5, 0, 0))
    _, frames = alone(scene, 1)
    motion = along_x(0.0, 2, 0.0, z=1.2)

    class Track:
        def __init__(self, name):
            at = [f.objects[name] for f in frames]
            self.position, self.quaternion = (np.array([p[i] for p in at]) for i in (0, 1))

    report = penetration(motion, body, scene, objects={n: Track(n) for n in ("door/panel", "ball")})
    assert report.by_name["ball"].max() == 0.0
    assert 5.0 < report.by_name["door/panel"].max() <= 30.1  # the panel is 40 mm thick, its knob 60


def test_a_door_goes_on_when_things_come_and_go():
    scene = Scene(gravity=9.81)
    scene.add_articulated("door", DOOR, velocities={"hinge": 1.0})

    def angles(come_and_go):
        simulator = Simulator(scene, body=[])
        simulator.reset([])
        found = []
        for i in range(30):
            if come_and_go and i == 10:
                simulator.add_object("ball", Sphere(0.1), mass=1.0, position=(5, 5, 5))
            if come_and_go and i == 20:
                simulator.remove_object("ball")
            found.append(simulator.step([]).joints["door/hinge"])
        return found

    assert angles(True) == angles(False)


def test_a_spec_with_meshes_comes_back_from_a_scene_elsewhere(tmp_path):
    """To the last bit, and where its meshes have gone a result leaves it out."""
    (tmp_path / "bot" / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "bot" / "meshes" / "c.obj")
    text = DOOR.replace("<mujoco>", '<mujoco><compiler meshdir="meshes"/><asset><mesh name="c" '
                        'file="c.obj"/></asset>').replace(
        "</body>", '<geom type="mesh" mesh="c" mass="1.23456789"/></body>', 1)  # fmt: skip
    (tmp_path / "bot" / "door.xml").write_text(text)
    scene = Scene()
    scene.add_articulated("door", mujoco.MjSpec.from_file(str(tmp_path / "bot" / "door.xml")))
    (tmp_path / "away").mkdir()
    scene.save(tmp_path / "away" / "scene.yaml")
    again = Scene.load(tmp_path / "away" / "scene.yaml")
    for one, other in zip(
        scene.articulated["door"].links, again.articulated["door"].links, strict=True
    ):
        assert (one.mass, one.position.tolist()) == (other.mass, other.position.tolist())
        assert one.inertia.tolist() == other.inertia.tolist()
    record = SceneRecord.of(scene)
    assert record.missing() == {}
    (tmp_path / "bot" / "meshes" / "c.obj").unlink()
    assert record.missing() == {"door": "c.obj is not there"}


def test_its_mass_is_what_was_asked_for_and_stays_in_files(tmp_path):
    scene = Scene()
    plain = scene.add_articulated("plain", DOOR)
    heavy = scene.add_articulated("heavy", DOOR, mass=50.0)
    assert heavy.mass == pytest.approx(50.0)
    factor = 50.0 / plain.mass
    for a, b in zip(plain.links, heavy.links, strict=True):
        np.testing.assert_allclose(b.inertia, a.inertia * (1.0 if a.fixed else factor))
    other = changed(scene, {"plain": 20.0}, {})
    for name in ("scene.yaml", "scene.json"):
        other.save(tmp_path / name)
        again = Scene.load(tmp_path / name).articulated
        assert {n: a.mass for n, a in again.items()} == {
            n: a.mass for n, a in other.articulated.items()
        }
    with pytest.raises(InputError, match="mass"):
        scene.add_articulated("none", DOOR, mass=0.0)


def test_links_of_plugins_are_no_links_of_the_robot():
    text = URDF.format(inertial=INERTIAL)
    plugin = "<gazebo><plugin><link>a</link><link>b</link><joint>c</joint></plugin></gazebo>"
    within = text.replace("<robot", "<robot", 1)
    at = within.index(">", within.index("<robot")) + 1
    scene = Scene()
    scene.add_articulated("lid", within[:at] + plugin + within[at:])
    assert scene.articulated["lid"].link_names


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        (b"\xff\xfe\x00", InputError, "bytes that are no text"),
        ("no such file " * 40, FileError, "cannot be reached|there is no such file"),
    ],
)
def test_sources_that_are_none(source, error, words):
    with pytest.raises(error, match=words) as found:
        Scene().add_articulated("it", source)
    assert len(str(found.value)) < 900


def test_a_text_may_begin_with_the_mark_of_its_encoding():
    scene = Scene()
    scene.add_articulated("door", "\ufeff" + DOOR)
    scene.add_articulated("bytes", DOOR.encode("utf-8-sig"))


def test_meshes_in_memory_are_those_that_were_given(tmp_path, monkeypatch):
    """Not those of files in the working folder that are called so."""
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((0.1, 0.1, 0.1)).export("t.obj")
    given = trimesh.creation.box((1.0, 1.0, 1.0)).export(file_type="obj").encode()
    text = DOOR.replace("<mujoco>", '<mujoco><asset><mesh name="t" file="t.obj"/></asset>').replace(
        "</body>", '<geom type="mesh" mesh="t" mass="1"/></body>', 1)  # fmt: skip
    spec = mujoco.MjSpec.from_string(text, assets={"t.obj": given})
    door = Scene().add_articulated("door", spec)
    shapes = [g.shape for link in door.links for g in link.geoms if isinstance(g.shape, Mesh)]
    assert np.ptp(shapes[0].vertices, axis=0) == pytest.approx(1.0)
