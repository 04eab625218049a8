# Written by tools/make_stubs.py. Arrays are C-contiguous; their shapes are
# noted where they are fixed: `*` is any length.
"""Native core of halfphysics."""

from collections.abc import Sequence
from typing import Annotated, Any

import numpy
from numpy.typing import NDArray


class tuning:
    """Constants of the core that Python shares: see tuning.h."""

    least_clearance: float = 2e-05

    root_recovery_time: float = 0.3

    return_per_motion: float = 3.0

    limp_time: float = 0.14

    untouched_resistance: float = 100.0

    range_lever: float = 0.1

    range_return: float = 3.0

    fastest_internal_spin: float = 100.0

    velocity_rounding: float = 1e-09

    pull_share: float = 0.97

    resist_share: float = 0.9

    resist_rounds: int = 6

    yield_tolerance: float = 0.02

    safe_yield_rounds: int = 60

    yield_rounds: int = 60

    yield_over_relaxation: float = 1.5

    least_yield_rate: float = 0.001

    rigid_resistance: float = 10000000000.0

class MeshTree:
    def __init__(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg1: Annotated[NDArray[numpy.int32], "(*, 3)"],
        /,
    ) -> None: ...

    def __len__(self) -> int: ...

    @property
    def shares(self) -> int: ...

class SkinShapes:
    def __init__(
        self,
        *,
        body: Annotated[NDArray[numpy.int32], "(*,)"],
        dof: Annotated[NDArray[numpy.int32], "(*,)"],
        parent: Annotated[NDArray[numpy.int32], "(*,)"],
        joint: Annotated[NDArray[numpy.float64], "(*, 3)"],
        rest: Annotated[NDArray[numpy.float64], "(*, 3)"],
        first: Annotated[NDArray[numpy.int32], "(*,)"],
        at: Annotated[NDArray[numpy.int32], "(*,)"],
        weight: Annotated[NDArray[numpy.float64], "(*,)"],
        bend: Annotated[NDArray[numpy.float64], "(*, *, *)"],
        part: Annotated[NDArray[numpy.int32], "(*,)"],
        start: Annotated[NDArray[numpy.int32], "(*,)"],
        vertex: Annotated[NDArray[numpy.int32], "(*,)"],
    ) -> None: ...

    def __len__(self) -> int: ...

class Stepper:
    def __init__(self) -> None: ...

    def set_model(
        self,
        *,
        parent: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_first: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_count: Annotated[NDArray[numpy.int32], "(*,)"],
        dof_first: Annotated[NDArray[numpy.int32], "(*,)"],
        dof_count: Annotated[NDArray[numpy.int32], "(*,)"],
        pos: Annotated[NDArray[numpy.float64], "(*, 3)"],
        quat: Annotated[NDArray[numpy.float64], "(*, 4)"],
        ipos: Annotated[NDArray[numpy.float64], "(*, 3)"],
        iquat: Annotated[NDArray[numpy.float64], "(*, 4)"],
        mass: Annotated[NDArray[numpy.float64], "(*,)"],
        inertia: Annotated[NDArray[numpy.float64], "(*, 3)"],
        jnt_type: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_qpos: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_dof: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_body: Annotated[NDArray[numpy.int32], "(*,)"],
        jnt_pos: Annotated[NDArray[numpy.float64], "(*, 3)"],
        jnt_axis: Annotated[NDArray[numpy.float64], "(*, 3)"],
        qpos0: Annotated[NDArray[numpy.float64], "(*,)"],
        armature: Annotated[NDArray[numpy.float64], "(*,)"],
    ) -> None: ...

    def set_joint_forces(
        self,
        *,
        damping: Annotated[NDArray[numpy.float64], "(*,)"],
        stiffness: Annotated[NDArray[numpy.float64], "(*,)"],
        spring: Annotated[NDArray[numpy.float64], "(*,)"],
        limited: Annotated[NDArray[numpy.int32], "(*,)"],
        range: Annotated[NDArray[numpy.float64], "(*, 2)"],
    ) -> None: ...

    def set_drive(
        self,
        *,
        time_constant: float,
        recovery_rate: float,
        recover_root: bool,
        root_speed: float,
    ) -> None: ...

    def set_contact(
        self,
        *,
        clearance: float,
        clearance_range: float,
        depenetration_speed: float,
        tolerance: float,
        max_sweeps: int,
        gravity: Annotated[NDArray[numpy.float64], "(*,)"],
    ) -> None: ...

    def set_baselines(
        self,
        *,
        internal_forces: bool,
        joint_damping: float,
        torque_frequency: float,
        torque_damping: float,
    ) -> None: ...

    def set_prescribed(self, arg: int, /) -> None: ...

    def finish(self, arg: Sequence[int], /) -> None: ...

    def set_stiffness(self, arg: Annotated[NDArray[numpy.float64], "(*,)"], /) -> None: ...

    def stiffness(self) -> NDArray[numpy.float64]: ...

    def set_strength(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def set_joint_ranges(
        self,
        person: int,
        *,
        axes: Annotated[NDArray[numpy.float64], "(*,)"],
        lower: Annotated[NDArray[numpy.float64], "(*,)"],
        upper: Annotated[NDArray[numpy.float64], "(*,)"],
    ) -> None: ...

    def set_waiting(self, arg: bool, /) -> None: ...

    def set_footing(
        self,
        *,
        person: int,
        joints: Annotated[NDArray[numpy.int32], "(*, 3)"],
        soles: Annotated[NDArray[numpy.int32], "(*,)"],
        hands: int,
        body: Annotated[NDArray[numpy.int32], "(*,)"],
        weight: Annotated[NDArray[numpy.float64], "(*,)"],
        local: Annotated[NDArray[numpy.float64], "(*, 3)"],
        normal: Annotated[NDArray[numpy.float64], "(*, 3)"],
    ) -> None: ...

    def person_qpos(self, arg: int, /) -> int: ...

    def person_qpos_count(self, arg: int, /) -> int: ...

    def add_shape(
        self,
        arg0: int,
        arg1: int,
        arg2: int,
        arg3: int,
        arg4: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg5: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg6: float,
        arg7: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def set_slack(self, arg: float, /) -> None: ...

    def add_skin_shapes(
        self,
        arg0: SkinShapes,
        arg1: int,
        arg2: Annotated[NDArray[numpy.int32], "(*,)"],
        /,
    ) -> None: ...

    def add_half_space(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: float,
        /,
    ) -> None: ...

    def add_hull(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg3: float,
        arg4: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def add_mesh(self, arg0: int, arg1: MeshTree, /) -> None: ...

    def set_soft_static(
        self,
        arg0: str,
        arg1: float,
        arg2: float,
        arg3: float,
        arg4: float,
        arg5: float,
        arg6: float,
        arg7: Annotated[NDArray[numpy.float64], "(*, 3)"],
        /,
    ) -> None: ...

    def set_soft_shape(
        self,
        arg0: str,
        arg1: float,
        arg2: float,
        arg3: float,
        arg4: float,
        arg5: float,
        arg6: float,
        /,
    ) -> None: ...

    def set_samples(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg2: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def set_skin_samples(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.int32], "(*,)"],
        arg2: Annotated[NDArray[numpy.float64], "(*,)"],
        arg3: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg4: Annotated[NDArray[numpy.int32], "(*,)"],
        arg5: Annotated[NDArray[numpy.float64], "(*,)"],
        arg6: Annotated[NDArray[numpy.float64], "(*,)"],
        arg7: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def set_pairings(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, *)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, *)"],
        arg2: Annotated[NDArray[numpy.float64], "(*, *)"],
        /,
    ) -> None: ...

    def set_self_pairs(self, arg: Annotated[NDArray[numpy.float64], "(*, *)"], /) -> None: ...

    def add_trajectory(
        self,
        arg0: int,
        arg1: float,
        arg2: bool,
        arg3: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg4: Annotated[NDArray[numpy.float64], "(*, 4)"],
        /,
    ) -> None: ...

    def start_asleep(self, arg: int, /) -> None: ...

    def reset(
        self,
        qpos: Annotated[NDArray[numpy.float64], "(*,)"],
        qvel: Annotated[NDArray[numpy.float64], "(*,)"],
        stand: bool = True,
    ) -> None: ...

    def frame(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: float,
        arg2: int,
        arg3: bool,
        /,
    ) -> NDArray[numpy.float64]: ...

    def run(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, *)"],
        arg1: float,
        arg2: int,
        arg3: bool,
        arg4: float,
        arg5: Annotated[NDArray[numpy.float64], "(*, *)"],
        arg6: Annotated[NDArray[numpy.float64], "(*, *)"],
        /,
    ) -> dict[str, Any]: ...

    def set_velocity(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def adopt(
        self,
        arg0: Stepper,
        arg1: Annotated[NDArray[numpy.int32], "(*,)"],
        arg2: Annotated[NDArray[numpy.int32], "(*,)"],
        /,
    ) -> None: ...

    def save(self) -> NDArray[numpy.float64]: ...

    def load(self, arg: Annotated[NDArray[numpy.float64], "(*,)"], /) -> None: ...

    def qpos(self) -> NDArray[numpy.float64]: ...

    def qvel(self) -> NDArray[numpy.float64]: ...

    def clearance(self) -> float: ...

    def clearances(
        self,
        qpos: Annotated[NDArray[numpy.float64], "(*, *)"],
        range: float,
        nearest: Annotated[NDArray[numpy.int32], "(*, *)"] | None = None,
    ) -> NDArray[numpy.float64]: ...

    def pair_gaps(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, *)"],
        /,
    ) -> NDArray[numpy.float64]: ...

    def touches(self) -> NDArray[numpy.float64]: ...

    def soft_contacts(self) -> dict[str, Any]: ...

    def diagnostics(self) -> dict[str, Any]: ...

    def disturbed(self) -> NDArray[numpy.float64]: ...

    def inside(self) -> NDArray[numpy.float64]: ...

    def breaches(self) -> NDArray[numpy.float64]: ...

    def footing(self) -> NDArray[numpy.float64]: ...

    def torques(self) -> NDArray[numpy.float64]: ...

    def keep_pieces(self, arg: bool, /) -> None: ...

    def keep_times(self, arg: bool, /) -> None: ...

    def solve_times(self) -> NDArray[numpy.float64]: ...

    def frame_work(self) -> float: ...

    def blind(self, arg: int, /) -> None: ...

    def keep_trace(self, arg: bool, /) -> None: ...

    def trace(self) -> dict[str, Any]: ...

    def body_frames(self, arg: Annotated[NDArray[numpy.float64], "(*,)"], /) -> tuple[Any, ...]: ...

    def inertia_matrix(
        self,
        arg: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> NDArray[numpy.float64]: ...

    def inertia_solve(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> NDArray[numpy.float64]: ...

    def bias_forces(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> NDArray[numpy.float64]: ...

    def integrate(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: float,
        /,
    ) -> NDArray[numpy.float64]: ...

    def shape_vertices(self, arg: int, /) -> NDArray[numpy.float64]: ...

    def shape_points(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: int,
        /,
    ) -> NDArray[numpy.float64]: ...

    def shape_jacobian(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: int,
        arg2: int,
        /,
    ) -> NDArray[numpy.float64]: ...

def solve_contacts(
    arg0: Annotated[NDArray[numpy.float64], "(*, *)"],
    arg1: Annotated[NDArray[numpy.float64], "(*,)"],
    arg2: Annotated[NDArray[numpy.float64], "(*,)"],
    arg3: Annotated[NDArray[numpy.int32], "(*,)"],
    arg4: Annotated[NDArray[numpy.float64], "(*,)"],
    arg5: float,
    arg6: float,
    arg7: int,
    arg8: float,
    /,
) -> tuple[Any, ...]: ...

def coulomb_contact(
    arg0: Annotated[NDArray[numpy.float64], "(*, *)"],
    arg1: float,
    arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg3: Annotated[NDArray[numpy.float64], "(*, 3)"],
    /,
) -> NDArray[numpy.float64]: ...

def convex_distance(
    arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg1: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg2: float,
    arg3: Annotated[NDArray[numpy.float64], "(*,)"],
    arg4: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg5: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg6: float,
    arg7: Annotated[NDArray[numpy.float64], "(*,)"],
    /,
) -> tuple[Any, ...]: ...

def triangle_planes(
    arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg1: Annotated[NDArray[numpy.int32], "(*, 3)"],
    arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg3: float,
    arg4: Annotated[NDArray[numpy.float64], "(*,)"],
    arg5: float,
    /,
) -> tuple[Any, ...]: ...

def triangle_nearest(
    arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg1: Annotated[NDArray[numpy.int32], "(*, 3)"],
    arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg3: float,
    arg4: Annotated[NDArray[numpy.float64], "(*,)"],
    arg5: float,
    /,
) -> tuple[Any, ...]: ...

def triangle_gap(
    arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg1: Annotated[NDArray[numpy.int32], "(*, 3)"],
    arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
    arg3: float,
    arg4: Annotated[NDArray[numpy.float64], "(*,)"],
    arg5: Annotated[NDArray[numpy.float64], "(*, 3)"],
    /,
) -> float: ...

class Batch:
    def __init__(self, threads: int) -> None: ...

    def submit(
        self,
        key: int,
        stepper: Stepper,
        qpos: Annotated[NDArray[numpy.float64], "(*,)"],
        qvel: Annotated[NDArray[numpy.float64], "(*,)"],
        lambda_: Annotated[NDArray[numpy.float64], "(*,)"],
        targets: Annotated[NDArray[numpy.float64], "(*, *)"],
        dt: float,
        substeps: int,
        record: bool,
        stiffness: Annotated[NDArray[numpy.float64], "(*, *)"],
        out: Annotated[NDArray[numpy.float64], "(*, *)"],
    ) -> None: ...

    def ended(self, seconds: float) -> list[int]: ...

    def take(self, key: int) -> dict[str, Any]: ...

    def close(self) -> None: ...

def catch_engine_errors(arg: int, /) -> None: ...

def run_worlds(arg0: Sequence[HostedWorld], arg1: int, /) -> list[str]: ...

class HostedWorld:
    def __init__(self, arg: Stepper, /) -> None: ...

    def set_arrays(
        self,
        arg0: NDArray[numpy.float64],
        arg1: NDArray[numpy.float64],
        arg2: NDArray[numpy.float64],
        arg3: NDArray[numpy.float64],
        arg4: NDArray[numpy.float64],
        arg5: NDArray[numpy.float64],
        arg6: NDArray[numpy.float64],
        arg7: NDArray[numpy.float64],
        arg8: Annotated[NDArray[numpy.int32], "(*,)"],
        arg9: Annotated[NDArray[numpy.int32], "(*,)"],
        /,
    ) -> None: ...

    def set_engine(self, arg0: int, arg1: int, arg2: int, arg3: bool, /) -> None: ...

    def set_masses(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg2: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg3: Annotated[NDArray[numpy.float64], "(*, 4)"],
        arg4: Annotated[NDArray[numpy.float64], "(*,)"],
        arg5: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def start(self) -> None: ...

    def aim(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: int,
        arg2: float,
        /,
    ) -> None: ...

    def run(self) -> None: ...

    @property
    def error(self) -> str: ...

    def begin(self) -> None: ...

    def before(self, arg: int, /) -> None: ...

    def after(self, arg: int, /) -> None: ...

    def end(self) -> None: ...

    def forces(self) -> NDArray[numpy.float64]: ...

    def set_forces(self, arg: Annotated[NDArray[numpy.float64], "(*, *)"], /) -> None: ...

    def show(self) -> None: ...

    def pushes(self) -> bool: ...

    def points(self) -> NDArray[numpy.float64]: ...

class Fleet:
    def __init__(
        self,
        worlds: int,
        threads: int,
        *,
        bodies: int,
        motors: int,
        groups: int,
    ) -> None: ...

    def put(
        self,
        world: int,
        stepper: object,
        *,
        bodies: Annotated[NDArray[numpy.int32], "(*,)"],
        motors: Annotated[NDArray[numpy.int32], "(*,)"],
        effort: Annotated[NDArray[numpy.float64], "(*,)"],
        shape_group: Annotated[NDArray[numpy.int32], "(*,)"],
        static_group: Annotated[NDArray[numpy.int32], "(*,)"],
    ) -> None: ...

    def frame(
        self,
        *,
        active: Annotated[NDArray[numpy.int32], "(*,)"],
        targets: Annotated[NDArray[numpy.float64], "(*, *)"],
        rests: Annotated[NDArray[numpy.float64], "(*, *)"],
        rates: Annotated[NDArray[numpy.float64], "(*, *)"],
        dt: float,
        substeps: int,
        poses: Annotated[NDArray[numpy.float64], "(*, *)"],
        states: Annotated[NDArray[numpy.float64], "(*, *)"],
        impulses: Annotated[NDArray[numpy.float64], "(*, *)"],
    ) -> None: ...

def kinematics(
    rotations: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
    root: Annotated[NDArray[numpy.float64], "(*, 3)"],
    rest_joints: Annotated[NDArray[numpy.float64], "(*, 3)"],
    parents: Annotated[NDArray[numpy.int32], "(*,)"],
    positions: NDArray[numpy.float64],
    quaternions: NDArray[numpy.float64],
) -> None:
    """
    World positions (T, J, 3) and quaternions (T, J, 4) of the joints, into the last two.
    """

def skin(
    rest_vertices: Annotated[NDArray[numpy.float64], "(*, 3)"],
    rest_joints: Annotated[NDArray[numpy.float64], "(*, 3)"],
    first: Annotated[NDArray[numpy.int32], "(*,)"],
    joint: Annotated[NDArray[numpy.int32], "(*,)"],
    weights: Annotated[NDArray[numpy.float64], "(*,)"],
    posedirs: Annotated[NDArray[numpy.float64], "(*, 3, *)"],
    rotations: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
    positions: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
    quaternions: Annotated[NDArray[numpy.float64], "(*, *, 4)"],
    subset: Annotated[NDArray[numpy.int32], "(*,)"],
    all: bool,
    threads: int,
    out: NDArray[numpy.float64],
    group_first: Annotated[NDArray[numpy.int32], "(*,)"] | None = None,
    wanted: Annotated[NDArray[numpy.uint8], "(*, *)"] | None = None,
) -> None:
    """
    Skinned vertices (T, n, 3) into `out`; `posedirs` of zero rows: no pose blend shapes. Of vertices in groups only those in frames where their group is `wanted` (T, groups).
    """

class TriangleTree:
    """
    Tree over a triangle soup: vertices (V, 3) [m], faces (F, 3). winding: also keep what `winding` and `exceeds` need.
    """

    def __init__(
        self,
        vertices: Annotated[NDArray[numpy.float64], "(*, 3)"],
        faces: Annotated[NDArray[numpy.int32], "(*, 3)"],
        winding: bool = False,
    ) -> None: ...

    def distance(
        self,
        points: Annotated[NDArray[numpy.float64], "(*, 3)"],
        threads: int = 1,
    ) -> tuple[Any, ...]:
        """Distances (n,) [m], nearest faces (n,) and closest points (n, 3) [m]."""

    def crossings(
        self,
        points: Annotated[NDArray[numpy.float64], "(*, 3)"],
        threads: int = 1,
    ) -> NDArray[numpy.int32]:
        """
        Signed crossings of the rays upward (n,): the winding number of closed triangles.
        """

    def winding(
        self,
        points: Annotated[NDArray[numpy.float64], "(*, 3)"],
        tolerance: float = 1e-06,
        threads: int = 1,
    ) -> NDArray[numpy.float64]:
        """
        Generalised winding numbers (n,), off by at most `tolerance`; 0: the full sum.
        """

    def exceeds(
        self,
        points: Annotated[NDArray[numpy.float64], "(*, 3)"],
        threshold: Annotated[NDArray[numpy.float64], "(*,)"],
        threads: int = 1,
    ) -> NDArray[numpy.uint8]:
        """
        1 where the winding number is over threshold (n,), else 0: as the full sum would say.
        """

class PointGrid:
    """Points (n, 3) to find near triangles."""

    def __init__(self, arg: Annotated[NDArray[numpy.float64], "(*, 3)"], /) -> None: ...

class TouchingThing:
    """Shapes that touch, in their thing's frame."""

    def __init__(self) -> None: ...

    def add_plane(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(3, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: Annotated[NDArray[numpy.float64], "(*,)"],
        arg3: float,
        /,
    ) -> None: ...

    def add_box(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(3, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def add_capsule(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(3, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: float,
        arg3: float,
        /,
    ) -> None: ...

    def add_cylinder(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(3, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: float,
        arg3: float,
        /,
    ) -> None: ...

    def add_triangles(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(3, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*,)"],
        arg2: TriangleTree,
        arg3: Annotated[NDArray[numpy.float64], "(*, 4)"],
        /,
    ) -> None: ...

    def distance(
        self,
        arg: Annotated[NDArray[numpy.float64], "(*, 3)"],
        /,
    ) -> NDArray[numpy.float64]: ...

    def close(
        self,
        centres: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
        radii: Annotated[NDArray[numpy.float64], "(*, *)"],
        asked: Annotated[NDArray[numpy.uint8], "(*, *)"],
        position: Annotated[NDArray[numpy.float64], "(*, 3)"],
        turn: Annotated[NDArray[numpy.float64], "(*, 3, 3)"],
        reach: float,
    ) -> None:
        """
        Which balls (t, g) of those asked about are at most `reach` from the thing: into `asked`.
        """

    def near(
        self,
        posed: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
        first: Annotated[NDArray[numpy.int32], "(*,)"],
        close: Annotated[NDArray[numpy.uint8], "(*, *)"],
        position: Annotated[NDArray[numpy.float64], "(*, 3)"],
        turn: Annotated[NDArray[numpy.float64], "(*, 3, 3)"],
        reach: float,
        points: PointGrid | None,
        off: float,
        faces: Annotated[NDArray[numpy.int32], "(*, 3)"],
    ) -> tuple[Any, ...]:
        """
        Vertices of a skin near the thing, and points near the skin: two tuples of rows.
        """

class GapThing:
    """What a thing touches by: half-spaces, hulls, triangles."""

    def __init__(self) -> None: ...

    def add_half_space(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*,)"],
        arg1: float,
        /,
    ) -> None: ...

    def add_hull(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg2: float,
        arg3: Annotated[NDArray[numpy.float64], "(*,)"],
        /,
    ) -> None: ...

    def add_mesh(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg1: Annotated[NDArray[numpy.int32], "(*, 3)"],
        /,
    ) -> None: ...

    def between(
        self,
        arg0: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg1: Annotated[NDArray[numpy.float64], "(*, 3, 3)"],
        arg2: GapThing,
        arg3: Annotated[NDArray[numpy.float64], "(*, 3)"],
        arg4: Annotated[NDArray[numpy.float64], "(*, 3, 3)"],
        arg5: float,
        /,
    ) -> NDArray[numpy.float64]:
        """
        Distances (r,) of its hulls from another thing, both at their poses of every row; inf beyond range.
        """

    def gaps(
        self,
        posed: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
        frame: Annotated[NDArray[numpy.int32], "(*,)"],
        first: Annotated[NDArray[numpy.int32], "(*,)"],
        last: Annotated[NDArray[numpy.int32], "(*,)"],
        hull_first: Annotated[NDArray[numpy.int32], "(*,)"],
        hull_vertex: Annotated[NDArray[numpy.int32], "(*,)"],
        position: Annotated[NDArray[numpy.float64], "(*, 3)"],
        turn: Annotated[NDArray[numpy.float64], "(*, 3, 3)"],
        range: float,
    ) -> NDArray[numpy.float64]:
        """
        Distances (r,) between hulls first to last of a skin and the thing; inf beyond range.
        """

def part_balls(
    positions: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
    quaternions: Annotated[NDArray[numpy.float64], "(*, *, 4)"],
    joint: Annotated[NDArray[numpy.int32], "(*,)"],
    group: Annotated[NDArray[numpy.int32], "(*,)"],
    centre: Annotated[NDArray[numpy.float64], "(*, 3)"],
    radius: Annotated[NDArray[numpy.float64], "(*,)"],
    wanted: Annotated[NDArray[numpy.uint8], "(*, *)"],
) -> tuple[Any, ...]:
    """
    Centres (T, groups, 3) and radii (T, groups) of balls around what joints carry of each group where it is wanted (T, groups); -inf: nothing.
    """

def spread_wrenches(
    wrench: Annotated[NDArray[numpy.float64], "(*, 6)"],
    first: Annotated[NDArray[numpy.int32], "(*,)"],
    arm: Annotated[NDArray[numpy.float64], "(*, 3)"],
    normal: Annotated[NDArray[numpy.float64], "(*, 3)"],
    friction: Annotated[NDArray[numpy.float64], "(*,)"],
    ready: Annotated[NDArray[numpy.float64], "(*,)"],
    *,
    penalties: Annotated[NDArray[numpy.float64], "(*,)"],
    moments: float,
    shear: float,
    tolerance: float,
    steps: int,
    searches: int,
) -> NDArray[numpy.float64]:
    """
    Forces (n, 3) at places first[f] to first[f + 1] of every frame that come closest to its wrench (T, 6).
    """

def put_rotations(
    rotations: Annotated[NDArray[numpy.float64], "(*, *, 3)"],
    at: Annotated[NDArray[numpy.int32], "(*,)"],
    out: Annotated[NDArray[numpy.float64], "(*, *)"],
) -> None: ...

def rotations_of(
    coordinates: Annotated[NDArray[numpy.float64], "(*, *)"],
    at: Annotated[NDArray[numpy.int32], "(*,)"],
) -> NDArray[numpy.float64]: ...

def run_world(bytes: bytes, frames: int) -> NDArray[numpy.float64]: ...
