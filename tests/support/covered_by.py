"""The tests of a source file that has no test file of its own name.

    PYTHONPATH=tests python -m support.covered_by src/halfphysics/scene/items.py

prints the tests of a file: that of its name, and those listed here. `tests/test_mirror.py` keeps
the list true: every source file has tests, every line is needed, every test in it is there.
"""

from __future__ import annotations

import sys
from fnmatch import fnmatchcase
from pathlib import Path

from support.paths import ROOT, TESTS

SOURCES = ROOT / "src"

#: Source files below src ("*" stands for any characters) -> tests below tests.
COVERED_BY = {
    "halfphysics/__main__.py": "cli/test_cli.py",
    "halfphysics/bench/envs.py": "bench/test_bench.py",
    "halfphysics/envs/pictures.py": "envs/test_single.py envs/test_vector.py",
    "halfphysics/envs/task.py": "envs/test_tasks.py envs/test_vector.py",
    "halfphysics/envs/walkers.py": "envs/test_corridor.py envs/test_held_door.py",
    "halfphysics/errors.py": "test_api.py",
    "halfphysics/settings.py": "test_api.py base/test_validation.py cli/test_cli.py",
    "halfphysics/actors/actor.py": "actors/test_person.py",
    "halfphysics/actors/figure.py": "actors/test_walker.py actors/test_reach_for.py",
    "halfphysics/actors/floor_plan.py": "actors/test_route.py",
    "halfphysics/actors/foot.py": "actors/test_walker.py",
    "halfphysics/actors/foot_lock.py": "actors/test_mixed.py",
    "halfphysics/actors/footprints.py": "actors/test_mixed.py",
    "halfphysics/actors/gaze.py": "actors/test_look_at.py",
    "halfphysics/actors/goals.py": "actors/test_person.py",
    "halfphysics/actors/inertia.py": "actors/test_mixed.py",
    "halfphysics/actors/passersby.py": "actors/test_way.py",
    "halfphysics/actors/poise.py": "actors/test_person.py actors/test_reach_for.py",
    "halfphysics/actors/reach.py": "actors/test_reach_for.py",
    "halfphysics/actors/seat.py": "actors/test_sit_on.py",
    "halfphysics/actors/steps.py": "actors/test_walk_to.py",
    "halfphysics/actors/stoop.py": "actors/test_reach_for.py",
    "halfphysics/actors/stride.py": "actors/test_walker.py",
    "halfphysics/base/digests.py": "sweep/store/test_sources.py",
    "halfphysics/base/document_*.py": "scene/test_scene_file.py sweep/plan/test_plan_file.py",
    "halfphysics/base/field_checks.py": "base/test_validation.py sweep/plan/test_plan.py",
    "halfphysics/base/foreign_json.py": "formats/video/test_video.py formats/test_plain.py",
    "halfphysics/base/in_notebook.py": "render/test_notebook.py",
    "halfphysics/base/npy.py": "base/test_npz.py formats/datasets/test_arctic.py",
    "halfphysics/base/pickle_budget.py": "base/test_restricted_pickle.py formats/test_hostile.py",
    "halfphysics/base/pickle_placeholders.py": "base/test_restricted_pickle.py",
    "halfphysics/base/torch_file.py": "base/test_stored_objects.py",
    "halfphysics/baselines/engine/*.py": "baselines/engine/test_engine.py",
    "halfphysics/baselines/reference.py": "native/stepping/test_baselines.py",
    "halfphysics/body/match.py": "body/test_body.py",
    "halfphysics/body/footing_points.py": "native/footing/test_footing.py",
    "halfphysics/body/model_paths.py": "body/test_model_files.py",
    "halfphysics/bench/*.py": "bench/test_bench.py",
    "halfphysics/body/shape_space.py": "body/test_body.py body/test_model_files.py",
    "halfphysics/body/skin_c*.py": "body/test_skin_hulls.py",
    "halfphysics/body/strength.py": "native/stepping/test_strength.py",
    "halfphysics/cli/convert.py": "cli/test_cli.py cli/test_formats.py",
    "halfphysics/cli/demo.py": "cli/test_cli.py",
    "halfphysics/cli/joint_options.py": "native/stepping/test_drive.py",
    "halfphysics/cli/measures*.py": "cli/test_cli.py",
    "halfphysics/live/clients.py": "live/test_server.py",
    "halfphysics/live/incoming.py": "live/test_session.py",
    "halfphysics/live/pages.py": "live/test_serve.py live/test_server.py",
    "halfphysics/live/scene_items.py": "live/test_wire.py",
    "halfphysics/cli/simulate.py": "cli/test_cli.py",
    "halfphysics/cli/view.py": "viewer/test_view.py",
    "halfphysics/formats/*.py": "formats/test_round_trips.py formats/amass/test_fields.py",
    "halfphysics/formats/amass/*.py": "formats/amass/test_amass.py",
    "halfphysics/formats/bvh/*.py": "formats/bvh/test_bvh.py formats/skeletons/test_retarget.py",
    "halfphysics/formats/positions/bones.py": "formats/positions/test_inverse_kinematics.py",
    "halfphysics/formats/positions/first_guess.py": "formats/positions/test_inverse_kinematics.py",
    "halfphysics/formats/positions/joint_priors.py": "formats/positions/test_inverse_kinematics.py",
    "halfphysics/formats/positions/layouts.py": "formats/positions/test_joint_array.py",
    "halfphysics/formats/positions/posed.py": "formats/positions/test_joint_array.py",
    "halfphysics/formats/estimates.py": "formats/video/test_video.py",
    "halfphysics/formats/mean_shape.py": "formats/video/test_video.py formats/test_plain.py",
    "halfphysics/formats/rotation_forms.py": "formats/test_plain.py",
    "halfphysics/formats/smplx_params.py": "formats/test_plain.py",
    "halfphysics/formats/video/*.py": "formats/video/test_video.py",
    "halfphysics/formats/datasets/arctic_object.py": "formats/datasets/test_arctic.py",
    "halfphysics/formats/datasets/assets.py": (
        "formats/datasets/test_grab.py formats/datasets/test_omomo.py"
    ),
    "halfphysics/formats/datasets/frame_folders.py": (
        "formats/datasets/test_prox.py formats/datasets/test_rich.py"
    ),
    "halfphysics/formats/datasets/median_shape.py": (
        "formats/datasets/test_behave.py formats/datasets/test_prox.py"
    ),
    "halfphysics/formats/datasets/recorded.py": (
        "formats/datasets/test_arctic.py formats/datasets/test_omomo.py"
    ),
    "halfphysics/formats/datasets/relaxed_fingers.py": (
        "formats/datasets/test_interact.py formats/datasets/test_intercap.py"
    ),
    "halfphysics/formats/datasets/rigid_place.py": (
        "formats/datasets/test_prox.py formats/datasets/test_rich.py"
    ),
    "halfphysics/formats/datasets/standing_axis.py": (
        "formats/datasets/test_emdb.py formats/datasets/test_threedpw.py"
    ),
    "halfphysics/formats/datasets/shape_from_joints.py": "formats/datasets/test_intermimic.py",
    "halfphysics/formats/datasets/subject.py": "formats/datasets/test_grab.py",
    "halfphysics/formats/datasets/trumans_*.py": "formats/datasets/test_trumans.py",
    "halfphysics/formats/gltf/*.py": "formats/gltf/test_gltf.py formats/gltf/test_container.py",
    "halfphysics/formats/skeletons/*.py": (
        "formats/skeletons/test_retarget.py formats/bvh/test_bvh.py"
    ),
    "halfphysics/formats/results/*.py": "formats/results/test_result_file.py",
    "halfphysics/geometry/colliders.py": "native/geometry/test_convex.py",
    "halfphysics/geometry/contact_pieces.py": "simulation/test_hollow_objects.py",
    "halfphysics/geometry/mesh_file_checks.py": "formats/test_hostile.py",
    "halfphysics/geometry/mesh.py": "geometry/test_mesh_files.py geometry/test_shapes.py",
    "halfphysics/geometry/parallel_rays.py": "geometry/test_piece_error.py",
    "halfphysics/geometry/piece_cache.py": "geometry/test_convex_decomposition.py",
    "halfphysics/geometry/shape_base.py": "geometry/test_shapes.py",
    "halfphysics/labels/bounding_spheres.py": "labels/test_reference.py",
    "halfphysics/labels/event_kinds.py": "labels/test_events.py",
    "halfphysics/labels/holds.py": "labels/test_events.py",
    "halfphysics/labels/loads.py": "labels/test_events.py",
    "halfphysics/labels/item_solids.py": "labels/test_reference.py labels/test_sampling.py",
    "halfphysics/labels/proximity.py": "labels/test_reference.py",
    "halfphysics/labels/slips.py": "labels/test_events.py",
    "halfphysics/labels/solver_contacts.py": "labels/test_contact_labels.py",
    "halfphysics/labels/tables.py": "labels/test_contact_labels.py",
    "halfphysics/metrics/*.py": "metrics/test_penetration.py metrics/test_contact_precision.py",
    "halfphysics/metrics/verdict.py": "metrics/test_judge.py",
    "halfphysics/motion/file_metadata.py": "motion/test_motion.py formats/amass/test_amass.py",
    "halfphysics/motion/joint_groups.py": "native/stepping/test_drive.py",
    "halfphysics/motion/pose.py": "motion/test_motion.py body/test_body.py",
    "halfphysics/motion/resampling.py": "motion/test_motion.py",
    "halfphysics/motion/skeleton.py": "body/test_body.py assets/test_body.py",
    "halfphysics/motion/smplx_names.py": "motion/test_motion.py",
    "halfphysics/live/protocols/*.py": "live/protocols/test_vmc.py live/protocols/test_udp.py",
    "halfphysics/mujoco/binding.py": "mujoco/test_control.py mujoco/test_host_model.py",
    "halfphysics/reference/algorithm1.py": "reference/test_step.py native/stepping/test_drive.py",
    "halfphysics/reference/contact.py": "reference/test_step.py native/contact/test_coulomb.py",
    "halfphysics/reference/strength.py": "reference/test_step.py native/stepping/test_strength.py",
    "halfphysics/render/film/*.py": "render/film/test_film.py",
    "halfphysics/results/*.py": "results/test_result.py formats/results/test_result_file.py",
    "halfphysics/scenarios/acting/*.py": (
        "scenarios/acting/test_acting.py scenarios/test_scenarios.py"
    ),
    "halfphysics/scenarios/props/*.py": (
        "scenarios/stories/test_drawers_and_laptops.py scenarios/test_scenarios.py"
    ),
    "halfphysics/scenarios/stories/*.py": (
        "scenarios/test_scenarios.py scenarios/stories/test_furniture.py campaigns/test_labels.py"
    ),
    "halfphysics/scenarios/stories/*_drawer.py": "scenarios/stories/test_drawers_and_laptops.py",
    "halfphysics/scenarios/stories/*_laptop.py": "scenarios/stories/test_drawers_and_laptops.py",
    "halfphysics/scenarios/stories/place_glass.py": "scenarios/stories/test_grasp_glass.py",
    "halfphysics/scene/items.py": "scene/test_scene.py",
    "halfphysics/scene/mjcf_*.py": "scene/test_articulated.py formats/test_hostile.py",
    "halfphysics/scene/object_builder.py": "scene/test_scene.py",
    "halfphysics/scene/scene_writer.py": "scene/test_scene_file.py",
    "halfphysics/scene/trajectories.py": "native/stepping/test_kinematic_bodies.py",
    "halfphysics/simulation/*.py": "simulation/test_simulator.py",
    "halfphysics/simulation/fingerprint.py": "simulation/test_state.py",
    "halfphysics/simulation/person_shapes.py": "native/collision/test_collision_shape.py",
    "halfphysics/simulation/start_warnings.py": "results/test_inside.py",
    "halfphysics/support/estimate.py": "support/test_support.py support/test_force_plates.py",
    "halfphysics/support/skin_grid.py": "support/test_patches.py",
    "halfphysics/sweep/make/*.py": "sweep/make/test_vary.py sweep/make/test_scene_factors.py",
    "halfphysics/sweep/make/making.py": "sweep/make/test_card.py sweep/make/test_time_limit.py",
    "halfphysics/sweep/plan/*.py": "sweep/plan/test_plan.py sweep/plan/test_factors.py",
    "halfphysics/sweep/report/summary.py": "cli/test_sweep.py",
    "halfphysics/sweep/run/engines.py": "sweep/run/test_driver.py",
    "halfphysics/sweep/store/*.py": "sweep/store/test_store.py sweep/store/test_disturbed.py",
    "halfphysics/sweep/store/card_page.py": "sweep/store/test_data_card.py",
    "halfphysics/sweep/store/comparing.py": "sweep/report/test_verify.py",
    "halfphysics/sweep/store/contents.py": "sweep/store/test_tar.py",
    "halfphysics/viewer/packing.py": "viewer/test_dents.py viewer/test_page.py",
    "halfphysics/viewer/*.py": "viewer/test_view.py viewer/test_view_browser.py",
    "halfphysics/viewer/catalog.py": "viewer/test_session.py",
    "halfphysics/viewer/figure.py": "viewer/test_stage.py",
    "halfphysics/viewer/knobs.py": "viewer/test_session.py",
    "halfphysics/viewer/core_files.py": "viewer/test_play_page.py viewer/test_play_page_browser.py",
    "halfphysics/viewer/live_*.py": "viewer/test_live_view.py",
    "halfphysics/viewer/numbers.py": "viewer/test_plots.py",
    "halfphysics/viewer/play_data.py": "viewer/test_play_page.py viewer/test_play_page_browser.py",
    "halfphysics/viewer/page_*.py": "viewer/test_page.py viewer/test_page_browser.py",
    "halfphysics/viewer/panel/*.py": "viewer/test_playground.py viewer/test_playground_browser.py",
    "halfphysics/writers/colors.py": "writers/test_gltf.py",
    "halfphysics/writers/correctives.py": "writers/test_gltf.py",
    "halfphysics/writers/gltf_buffer.py": "writers/test_gltf.py",
    "halfphysics/writers/mjcf_geoms.py": "writers/test_mjcf.py",
    "halfphysics/writers/take.py": "writers/test_gltf.py writers/test_usd.py",
    "native/assembly/*": "native/compiled/test_replay.py simulation/test_simulator.py",
    "native/capi/halfphysics.h": "native/capi/test_library.py",
    "native/capi/world_handle.*": "native/capi/test_library.py native/capi/test_editing.py",
    "native/compiled/*": "native/compiled/test_replay.py native/compiled/test_world_file.cpp",
    "native/bindings/*": "native/test_person.cpp reference/test_step.py",
    "native/bindings/render.cpp": "render/test_rasterizer.py",
    "native/bindings/skinning.cpp": "body/test_skinning.py",
    "native/collision/*": (
        "simulation/test_simulator.py campaigns/test_clear.py campaigns/test_skin.py"
    ),
    "native/collision/*depenetration.*": "campaigns/test_starts.py simulation/test_self_contact.py",
    "native/collision/*exit*": "campaigns/test_starts.py simulation/test_holding.py",
    "native/contact/*": "native/contact/test_contact_problem.py native/contact/test_squeezed.py",
    "native/footing/*": "native/footing/test_footing.py",
    "native/footing/bearing.*": "native/stepping/test_standing_load.py",
    "native/geometry/*": "geometry/test_mesh_queries.py native/geometry/test_convex.py",
    "native/geometry/skinning.*": "body/test_skinning.py",
    "native/labels/*": "labels/test_reference.py",
    "native/dynamics/chain_factor.*": "native/dynamics/test_inertia_factor.cpp",
    "native/dynamics/half_solve.*": "native/dynamics/test_inertia_factor.cpp",
    "native/dynamics/inertia.*": "native/dynamics/test_kinematic_tree.py",
    "halfphysics/simulation/call_recorder.py": "simulation/test_compile_world.py",
    "native/math/*": (
        "native/math/test_dense.cpp native/geometry/test_convex.py body/test_skinning.py"
    ),
    "native/render/*": "render/test_rasterizer.py",
    "native/support/*": "support/test_wrench_qp.py",
    "native/soft/*": "native/soft/test_condensation.cpp native/stepping/test_soft_contacts.cpp",
    "native/soft/foam_cells.*": "native/soft/test_soft_law.cpp",
    "native/stepping/*": (
        "reference/test_step.py native/test_person.cpp simulation/test_simulator.py"
    ),
    "native/stepping/baselines/*": "native/stepping/test_baselines.py baselines/test_forced.py",
    "native/stepping/contact_cache.*": "simulation/test_stacks.py",
    "native/stepping/held_load.*": "simulation/test_holding.py",
    "native/stepping/island_response.*": "native/stepping/test_islands.py",
    "native/stepping/host.*": "mujoco/test_contact_data.py mujoco/test_control.py",
    "native/stepping/hosting.*": "mujoco/test_control.py mujoco/test_contact_data.py",
    "native/bindings/hosted_world.cpp": "mujoco/test_engine.py mujoco/test_worlds.py",
    "native/stepping/restitution.*": "simulation/test_closed_forms.py",
    "native/stepping/self_response.*": "simulation/test_self_contact.py",
    "native/stepping/snapshot.*": "simulation/test_state.py",
}


def sources() -> list[str]:
    """Every file of code below src, but `__init__.py`."""
    found = (path for path in SOURCES.rglob("*") if path.suffix in (".py", ".h", ".cpp"))
    return sorted(p.relative_to(SOURCES).as_posix() for p in found if p.name != "__init__.py")


def own_test(source: str) -> str | None:
    """The test file that has the name of a source file, in the folder that mirrors its own."""
    path = Path(source.removeprefix("halfphysics/"))
    for suffix in (".py", ".cpp"):
        test = path.with_name(f"test_{path.stem}{suffix}")
        if (TESTS / test).is_file():
            return test.as_posix()
    return None


def lines(source: str) -> list[str]:
    """The lines of the list that match a source file."""
    return [pattern for pattern in COVERED_BY if matches(source, pattern)]


def matches(source: str, pattern: str) -> bool:
    """Whether a line matches a source file; "*" does not match subfolders."""
    return source.count("/") == pattern.count("/") and fnmatchcase(source, pattern)


def covering(source: str) -> list[str]:
    """Test files of a source file, that of its own name first."""
    listed = [test for line in lines(source) for test in COVERED_BY[line].split()]
    return list(dict.fromkeys([*filter(None, [own_test(source)]), *listed]))


if __name__ == "__main__":
    for name in sys.argv[1:]:
        inside = Path(name).resolve().relative_to(SOURCES).as_posix()
        print("\n".join(f"tests/{test}" for test in covering(inside)))
