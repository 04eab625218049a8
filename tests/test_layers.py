"""Imports run one way: folders of the package and of the native core, and allowed imports."""

from __future__ import annotations

import subprocess
import sys
from collections import defaultdict

import pytest

from support.imports import Import, cycles, imports, includes, modules

#: Extensions and the version, which are at the root and import nothing.
ROOT_NAMES = {"_native", "_render", "__version__"}

#: Folder (or module at the root) -> its allowed imports. Each may name only those above it.
LAYERS = {
    "errors": "",
    "base": "errors",
    "motion": "errors base",
    "geometry": "errors base _native",
    "body": "errors base motion geometry _native",
    "settings": "errors base motion body",
    "scene": "errors base motion geometry body",
    "results": "errors base motion geometry body settings scene",
    "adaptation": "errors base motion geometry body settings scene results",
    "support": "errors base motion geometry body scene results _native",
    "simulation": ("errors base motion geometry body settings scene results adaptation _native"),
    "reference": "base motion settings _native",
    "metrics": "errors base motion geometry body scene results simulation support _native",
    "baselines": (
        "errors base motion geometry body settings scene results simulation reference metrics "
        "_native"
    ),
    "repair": (
        "errors base motion geometry body settings scene results adaptation simulation metrics"
    ),
    "formats": (
        "errors base motion geometry body settings scene results adaptation simulation baselines "
        "__version__"
    ),
    "judging": "errors base motion body scene results metrics formats",
    "render": "errors base motion geometry body scene results _render",
    "writers": "errors base motion geometry body scene results simulation render __version__",
    "labels": "errors base motion geometry body scene results metrics _native",
    "mujoco": "errors base motion geometry body settings scene simulation _native",
    "scenarios": "errors base motion geometry body scene settings simulation",
    "live": (
        "errors base motion geometry body settings scene results simulation formats __version__"
    ),
    "actors": "errors base motion geometry body settings scene results simulation scenarios",
    "viewer": (
        "errors base motion geometry body settings scene results support simulation formats render "
        "labels scenarios live"
    ),
    "sweep": (
        "errors base motion geometry body settings scene results simulation baselines formats "
        "labels scenarios __version__"
    ),
    "envs": (
        "errors base motion geometry body settings scene results simulation render scenarios "
        "actors _native"
    ),
    "bench": (
        "errors base motion geometry body settings scene results simulation metrics baselines "
        "render labels mujoco scenarios viewer sweep envs _native"
    ),
    "cli": (
        "errors base motion body settings scene results simulation metrics baselines repair "
        "formats judging render writers scenarios live viewer sweep bench __version__"
    ),
}

#: Folder -> its subfolders -> the other subfolders that each may import, of those above it. The
#: modules beside them need only be free of cycles.
SUBFOLDERS = {
    "baselines": {"engine": ""},
    "formats": {
        "amass": "",
        "skeletons": "",
        "bvh": "skeletons",
        "datasets": "",
        "gltf": "skeletons datasets",
        "positions": "datasets skeletons",
        "results": "amass",
        "video": "skeletons positions",
    },
    "live": {"protocols": ""},
    "render": {"film": ""},
    "scenarios": {"acting": "", "props": "acting", "stories": "acting props"},
    "sweep": {
        "plan": "",
        "make": "plan",
        "store": "plan make",
        "run": "plan make store",
        "report": "plan make store run",
    },
    "viewer": {"panel": ""},
}

#: Imports that run back, each with its reason. All are late or for types: none runs on import.
BACK = {
    ("base.in_notebook", "render.notebook"): "objects show themselves in notebooks",
    ("motion.motion", "formats"): "Motion.load and Motion.save read and write every format",
    ("motion.motion", "formats.format"): "the type of what Motion.load takes beside the file",
    ("motion.motion", "body.body"): "the type of the body that Motion.grounded puts on the floor",
    ("results.result", "formats.results.result_file"): "Result.load",
    ("results.result", "formats.results.result_writer"): "Result.save",
    ("results.result", "metrics.result_report"): "Result.summary",
    ("results.result", "metrics.part_report"): "Result.parts",
    ("results.person_result", "support.estimate"): "PersonResult.support",
    ("results.person_result", "support.support"): "the type of PersonResult.support",
    ("formats.saving", "writers"): "Motion.save names what hp.export writes instead",
}

#: Folder of src/native -> folders that its files may include, of those above it. All may include
#: tuning.h.
NATIVE = {
    "math": "",
    "geometry": "math",
    "dynamics": "math",
    "contact": "math dynamics",
    "collision": "math geometry dynamics contact",
    "soft": "math geometry collision",
    "footing": "math geometry dynamics collision",
    "stepping": "geometry dynamics collision soft footing",
    "assembly": "math geometry dynamics collision stepping",
    "compiled": "assembly stepping",
    "capi": "assembly compiled",
    "labels": "math geometry",
    "support": "math",
    "render": "",
    "bindings": "math geometry stepping assembly compiled labels support render",
}

#: Includes that run back, each with its reason.
NATIVE_BACK = {
    ("dynamics/articulation.h", "contact/solver.h"): "the ends of joints are rows of the solver",
}


def folder(module: str) -> str:
    return module.split(".")[0]


def check_order(table: dict[str, str], outside: set[str] = frozenset()) -> None:
    """Every line names only those above it."""
    above = set(outside)
    for name, may in table.items():
        assert set(may.split()) <= above, f"{name} may import what is below it"
        above.add(name)


def test_the_tables_run_one_way():
    check_order(LAYERS, ROOT_NAMES)
    check_order(NATIVE)
    for subfolders in SUBFOLDERS.values():
        check_order(subfolders)


def test_every_folder_is_listed():
    listed = {*LAYERS, "", "__main__", "assets"}
    assert {folder(module) for module in modules()} | {"assets"} == listed
    inner = defaultdict(set)
    for module, path in modules().items():
        if path.name == "__init__.py" and module.count(".") == 1:
            inner[folder(module)].add(module.partition(".")[2])
    assert inner == {name: set(subfolders) for name, subfolders in SUBFOLDERS.items()}


@pytest.mark.parametrize("layer", LAYERS)
def test_a_folder_imports_what_it_may(layer):
    """Every allowed import exists: the table is up to date."""
    used = {
        folder(arrow.target)
        for arrow in imports()
        if folder(arrow.source) == layer and (arrow.source, arrow.target) not in BACK
    }
    assert used - {layer} == set(LAYERS[layer].split())


@pytest.mark.parametrize("layer", SUBFOLDERS)
def test_a_subfolder_imports_what_it_may(layer):
    used = {name: set() for name in SUBFOLDERS[layer]}
    for arrow in imports():
        source, target = arrow.source.split("."), arrow.target.split(".")
        if source[0] == target[0] == layer and min(len(source), len(target)) > 1:
            one, other = source[1], target[1]
            if one in used and other in used and one != other:
                used[one].add(other)
    assert used == {name: set(may.split()) for name, may in SUBFOLDERS[layer].items()}


def test_what_runs_back_is_named_and_late():
    """Every exception still exists, and none runs when its module is imported."""
    kinds = defaultdict(set)
    for arrow in imports():
        kinds[arrow.source, arrow.target].add(arrow.kind)
    assert {pair for pair in BACK if pair not in kinds} == set(), "stale"
    assert {pair for pair in BACK if "top" in kinds[pair]} == set(), "not late"


def test_the_root_imports_names_on_demand():
    """`halfphysics` itself loads a module when one of its names is used; `__main__` is the cli."""
    arrows = [arrow for arrow in imports() if arrow.source in ("", "__main__")]
    assert {arrow.kind for arrow in arrows if arrow.source == ""} <= {"type", "late"}
    assert {arrow.target for arrow in arrows if arrow.source == "__main__"} == {"cli"}
    users = {arrow.source for arrow in imports() if arrow.target == ""}
    assert users == set(), "import a name from where it is"


def test_no_modules_import_each_other():
    arrows = defaultdict(set)
    for arrow in imports():
        if arrow.kind == "top":
            arrows[arrow.source].add(arrow.target)
    assert cycles(arrows) == []


def test_a_cycle_would_be_found():
    arrows = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": set(), "f": {"d"}}
    assert cycles(arrows) == [["a", "b", "c"]]


def test_imports_are_found_wherever_they_are():
    found = imports()
    assert Import("motion.motion", "formats", "late") in found
    assert Import("motion.motion", "body.body", "type") in found
    assert Import("body.body", "motion.skeleton", "top") in found
    assert Import("body.skinning", "_native", "top") in found


def test_includes_of_the_native_core_run_one_way():
    used = {name: set() for name in NATIVE}
    for source, target in includes() - set(NATIVE_BACK):
        if target != "tuning.h":
            used[folder_of(source)].add(folder_of(target))
    found = {name: others - {name} for name, others in used.items()}
    assert found == {name: set(may.split()) for name, may in NATIVE.items()}
    assert set(NATIVE_BACK) <= includes(), "stale"


def folder_of(path: str) -> str:
    return path.split("/")[0]


def test_no_files_of_the_native_core_include_each_other():
    arrows = defaultdict(set)
    for source, target in includes():
        arrows[source].add(target)
    assert cycles(arrows) == []


@pytest.mark.parametrize(
    ("module", "late"),
    [
        ("halfphysics", {"numpy", "mujoco"}),
        ("halfphysics.sweep.run.work", {"numpy", "mujoco", "trimesh", "ray", "h5py"}),
        ("halfphysics.labels", {"mujoco", "trimesh", "scipy"}),
        ("halfphysics.sweep.make.vary", {"tyro", "viser", "ray", "h5py", "webdataset"}),
    ],
)
def test_what_is_heavy_is_imported_when_it_is_needed(module, late):
    script = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not late & set(loaded)
