"""The public face: a change here is a decision, and `import halfphysics` stays quick."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import halfphysics as hp

HEAVY = ("mujoco", "trimesh", "viser", "scipy", "tyro", "yaml", "PIL")

NAMES = """
JOINT_NAMES Body Box Capsule Cylinder HalfPhysicsError HalfPhysicsWarning Mesh Motion Plane Pose
Result Scene Sequence Settings Simulator Sphere __version__ attach baselines clips compile_world
connect errors export adapt Soft fix judge load_sequence metrics progress scenarios serve simulate
simulate_many support view bind step_worlds actors
"""

SETTINGS = (
    "* substeps stiffness drive_time recovery_rate weight blocked root root_speed clearance "
    "clearance_range contact self_contact depenetration_speed tolerance max_sweeps strength "
    "joint_limits soft_skin threads record"
)

# The public callables: name -> parameters, * before keyword-only ones.
PARAMETERS = {
    "Motion": "translation rotations fps betas gender model axes origin stiffness_scale "
    "holds recorded",
    "Motion.load": "path fps up hands model * gender frames clip assets floor",
    "Motion.from_smplx": "* fps global_orient transl body_pose jaw_pose leye_pose reye_pose "
    "left_hand_pose right_hand_pose betas expression gender model up hands_mean",
    "Motion.to_smplx": "self",
    "Motion.resample": "self fps",
    "Motion.grounded": "self body z * percentile",
    "Motion.save": "self path format * body",
    "Motion.rebased": "self body up",
    "clips": "path",
    "compile_world": "scene * body settings",
    "export": "what path * body fps colliders",
    "adapt": "motion scene body recorded * settings grip others",
    "load_sequence": "path assets * objects adapt grip ground fps up hands model gender frames "
    "clip floor",
    "Pose": "translation rotations axes stiffness_scale",
    "Body.default": "betas stature mass bones",
    "Body.load": "path betas gender * model v_template mass",
    "Body.joints": "self motion",
    "Body.vertices": "self motion frames * indices threads",
    "Body.save_mjcf": "self path",
    "Scene": "gravity",
    "Scene.load": "path",
    "Scene.save": "self path",
    "Scene.add_static": "self name shape * scale position quaternion up friction restitution soft",
    "Scene.add_object": "self name shape * mass density friction restitution com position "
    "quaternion velocity angular_velocity scale up start pieces "
    "threshold max_pieces soft",
    "Soft": "thickness stiffness damping law densification hysteresis recovery",
    "Soft.named": "name * thickness",
    "Scene.add_moving": "self name shape positions quaternions * fps friction restitution loop "
    "scale up soft",
    "Scene.add_articulated": "self name source * position quaternion friction restitution joints "
    "velocities mass",
    "Scene.ray": "self origin direction * ignore",
    "serve": "scene * body start settings fps host port token origins record listen forward",
    "connect": "url * token",
    "Simulator.ray": "self origin direction * ignore",
    "Scene.friction": "self a b mu",
    "Scene.ignore": "self a b",
    "Plane": "normal offset",
    "Box": "size",
    "Sphere": "radius",
    "Capsule": "radius length",
    "Cylinder": "radius length",
    "Settings": SETTINGS,
    "Settings.paper": "stiffness ** changes",
    "progress": "show",
    "judge": "paths * truth scene body jobs progress",
    "fix": "motion scene * body smooth level plant settings",
    "simulate": "motion scene * body settings stiffness allow_mismatch progress",
    "simulate_many": "jobs scenes * body settings stiffness allow_mismatch threads errors progress",
    "Simulator": "scene * body settings fps",
    "Simulator.reset": "self pose",
    "Simulator.step": "self pose dt",
    "Simulator.save_world": "self path",
    "Simulator.set_stiffness": "self value * person",
    "Simulator.velocity": "self name",
    "Simulator.set_velocity": "self name velocity angular_velocity",
    "Simulator.apply_impulse": "self name impulse point angular",
    "Simulator.add_object": "self name shape ** options",
    "Simulator.remove_object": "self name",
    "Simulator.attach": "self name part person",
    "Simulator.release": "self name",
    "Simulator.get_state": "self",
    "Simulator.set_state": "self state",
    "view": "result more * labels host port block",
    "attach": "spec body prefix",
    "bind": "model data humans * settings",
    "step_worlds": "controls poses dt * threads",
    "Result": "* people objects scene names contacts clearance lost_time settings substeps "
    "diagnostics inside breaches joints soft_contacts",
    "Result.save": "self path",
    "Result.load": "path * scene body",
    "Result.summary": "self",
    "Result.free_frames": "self person settle",
    "Result.parts": "self person",
    "metrics.mpjpe": "a b body",
    "metrics.mpjpe_global": "a b body",
    "metrics.penetration": "motion body scene * objects people threads progress",
    "metrics.success": "motion asked",
    "metrics.jerk": "motion body",
    "metrics.foot_skate": "motion body * ground height speed",
    "metrics.deviation": "result person * settle",
    "metrics.over_sequences": "reports",
    "metrics.penetrating_volume": "motion body scene * objects pitch",
    "metrics.contact_precision": "result * margin",
    "metrics.contact_forces": "result",
    "metrics.airborne": "motion body gravity",
    "metrics.floating": "motion body scene * objects reference tolerance",
    "metrics.physdiff": "motion body * ground",
    "metrics.unsupported_weight": "result person",
    "metrics.range_violations": "result person",
    "metrics.stance_slide": "result person",
    "metrics.net_force": "result person",
    "metrics.path_offset": "result person",
    "metrics.judge": "motion body scene truth * truth_body objects truth_objects ground",
    "metrics.Verdict": "* values missing frames fps",
    "metrics.gmd_skating_ratio": "joints fps * ground height speed",
    "metrics.foot_sliding_mm": "joints * ground",
    "metrics.foot_skate_from_height": "joints fps * ground",
    "metrics.foot_skate_ratio": "joints fps * ground",
    "metrics.foot_skate_from_contacts": "joints fps contacts",
    "metrics.foot_contact_consistency": "joints fps contacts * ground",
    "metrics.jitter": "joints fps",
    "metrics.acceleration_error": "joints truth fps",
    "metrics.stability": "motion body * ground",
    "metrics.self_penetration": "motion body * most",
    "metrics.scene_contact": "distance",
    "metrics.contact_scores": "contact truth",
    "metrics.wa_mpjpe": "joints truth",
    "metrics.w_mpjpe": "joints truth",
    "metrics.rte": "path truth",
    "metrics.world_foot_sliding": "soles truth * contact",
    "metrics.phc_success": "joints truth",
    "support.estimate": "motion scene * body cutoff",
    "baselines.Ablation": f"{SETTINGS} internal_forces joint_damping",
    "baselines.Torque": f"{SETTINGS} internal_forces joint_damping frequency damping",
    "baselines.Kinematic": SETTINGS,
    "baselines.Positions": SETTINGS,
    "baselines.Interpolated": SETTINGS,
    "baselines.EngineKinematic": SETTINGS,
    "baselines.EngineVelocity": SETTINGS,
    "baselines.from_options": "options",
    "baselines.options_of": "settings",
    "baselines.with_options": "settings options",
    "scenarios.names": "",
    "scenarios.load": "name ** chosen",
}


def python(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout.strip()


def test_names():
    assert sorted(hp.__all__) == sorted(NAMES.split())
    for name in hp.__all__:
        assert getattr(hp, name) is not None
        assert name in dir(hp)


def test_unknown_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'Motions'"):
        _ = hp.Motions


@pytest.mark.parametrize("name", PARAMETERS)
def test_parameters(name):
    thing = hp
    for part in name.split("."):
        thing = getattr(thing, part)
    said, starred = [], False
    for parameter in inspect.signature(thing).parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not starred:
            said.append("*")
            starred = True
        if parameter.kind is parameter.VAR_KEYWORD:
            said.append("**")
        said.append(parameter.name)
    assert " ".join(said) == PARAMETERS[name]


def test_every_setting_has_a_default_and_a_line_of_meaning():
    hp.Settings()
    source = inspect.getsource(hp.Settings)
    for name in inspect.signature(hp.Settings).parameters:
        after = source.split(f"    {name}: ", 1)[1].split("\n", 2)[1]
        assert after.strip().startswith('"""'), name


def test_the_function_is_not_hidden_by_a_module():
    """After any order of imports, `hp.simulate` is the function."""
    code = (
        "import halfphysics.simulation.simulate, halfphysics.simulation.simulator\n"
        "import halfphysics.results.result\n"
        "import halfphysics as hp\n"
        "print(callable(hp.simulate), type(hp.scenarios).__name__)"
    )
    assert python(code) == "True module"


def test_import_is_light():
    code = (
        "import sys; before = set(sys.modules)\n"
        "import halfphysics\n"
        f"print([m for m in {HEAVY} if m in sys.modules], len(set(sys.modules) - before) < 30)"
    )
    assert python(code) == "[] True"


def test_light_names_stay_light():
    code = (
        "import sys, halfphysics as hp\n"
        "hp.Motion, hp.Settings, hp.JOINT_NAMES, hp.Scene().add_static('a', hp.Box((1, 1, 1)))\n"
        f"print([m for m in {HEAVY} if m in sys.modules])"
    )
    assert python(code) == "[]"


def test_joint_names():
    assert len(hp.JOINT_NAMES) == 55
    assert hp.JOINT_NAMES[0] == "pelvis"
