"""Reads MJCF and URDF with MuJoCo in a process of its own: run as a script, imports no package.

MuJoCo's parser trusts its files: one that attaches itself overflows the stack and takes the process
along, one that copies copies fills the memory. `mjcf_process` starts this script and reads the
answer.

Standard input: JSON with `path` or `xml`, `urdf`, and `files`: name -> path of meshes that MuJoCo
itself would not find. Standard output: a line of JSON with `error`
or with names and counts, then an npz archive of the arrays of the compiled model.
"""

from __future__ import annotations

import io
import json
import sys
from typing import Any

#: The arrays of a compiled model that an articulated object is made from.
ARRAYS = (
    "geom_contype", "geom_conaffinity", "geom_bodyid", "geom_type", "geom_size", "geom_dataid",
    "geom_pos", "geom_quat", "body_parentid", "body_jntadr", "body_jntnum", "body_pos", "body_quat",
    "body_mass", "body_ipos", "body_inertia", "body_iquat", "body_gravcomp", "jnt_type",
    "jnt_bodyid", "jnt_limited", "jnt_qposadr", "jnt_dofadr", "jnt_pos", "jnt_axis", "jnt_range",
    "jnt_stiffness", "qpos0", "qpos_spring", "dof_damping", "dof_armature", "dof_frictionloss",
    "dof_dampingpoly", "jnt_stiffnesspoly", "mesh_vertadr", "mesh_vertnum", "mesh_vert",
)  # fmt: skip
COUNTS = ("ngeom", "nbody", "njnt", "nu", "ntendon", "neq", "nflex", "nmocap", "nkey")


def complete_urdf(mujoco: Any, spec: Any) -> None:
    """Settings that MJCF states explicitly: masses are never inferred from volumes."""
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.fusestatic = False


def contents(model: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Names and counts, and the arrays, of a compiled model. Older versions lack some arrays."""
    head: dict[str, Any] = {name: int(getattr(model, name)) for name in COUNTS}
    head["bodies"] = [model.body(b).name for b in range(model.nbody)]
    head["joints"] = [model.joint(j).name for j in range(model.njnt)]
    head["gravity"] = model.opt.gravity.tolist()
    return head, {name: getattr(model, name) for name in ARRAYS if hasattr(model, name)}


def _limit(memory: int, seconds: int) -> None:
    try:
        import resource
    except ImportError:  # Windows
        return
    kind = resource.RLIMIT_DATA if sys.platform == "linux" else resource.RLIMIT_AS
    limits = ((kind, memory), (resource.RLIMIT_CPU, seconds), (resource.RLIMIT_CORE, 0))
    for which, most in limits:
        try:
            _, hard = resource.getrlimit(which)
            most = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.setrlimit(which, (most, hard))
        except (ValueError, OSError):  # a system that does not take it
            continue


def read(request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Names and counts, and the arrays; or an error and what MuJoCo was doing."""
    import mujoco

    try:
        if "path" in request:
            spec = mujoco.MjSpec.from_file(request["path"])
        else:
            spec = mujoco.MjSpec.from_string(request["xml"])
    except (ValueError, RuntimeError) as error:
        return {"error": str(error), "in": "read"}, {}
    if request["urdf"]:
        complete_urdf(mujoco, spec)
    files = request.get("files", {})
    if files:
        spec.strippath = False
    for mesh in spec.meshes:
        mesh.file = files.get(mesh.file, mesh.file)
    try:
        return contents(spec.compile())
    except (ValueError, RuntimeError) as error:
        return {"error": str(error), "in": "compile"}, {}


def main() -> None:
    _limit(int(sys.argv[1]), int(sys.argv[2]))
    request = json.loads(sys.stdin.buffer.read())
    import numpy as np

    try:
        head, arrays = read(request)
    except MemoryError:
        head, arrays = {"error": "it needs too much memory", "in": "read"}, {}
    answer = io.BytesIO()
    np.savez(answer, **arrays)
    out = sys.stdout.buffer
    out.write(json.dumps(head).encode() + b"\n" + answer.getvalue())
    out.flush()


if __name__ == "__main__":
    main()
