"""The model of people and a scene, joined from trees that are made once each.

MuJoCo numbers bodies tree after tree, in the order in which the trees are added, and no number of a
tree depends on another tree. Those of a person, made once per body, and of an object are simple
enough to be written down: MuJoCo need not even be imported. Articulated objects are compiled, once
each. A world's arrays are all of them one after the other.
`tests/simulation/test_joined_model.py` holds them equal to MuJoCo's own, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.mjcf_person import UPRIGHT, principal
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.compiled_model import compiled_inertia

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.body.rigid_parts import Variant
    from halfphysics.scene.articulated import Articulated
    from halfphysics.scene.items import Object
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.holding import Hold

Array = NDArray[np.float64]

#: The arrays of an `MjModel` that make up a tree: per body, per joint, per coordinate and per
#: velocity.
BODY = (
    "body_parentid", "body_jntadr", "body_jntnum", "body_dofadr", "body_dofnum", "body_pos",
    "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia",
)  # fmt: skip
JOINT = (
    "jnt_type", "jnt_qposadr", "jnt_dofadr", "jnt_bodyid", "jnt_pos", "jnt_axis", "jnt_stiffness",
    "jnt_limited", "jnt_range",
)  # fmt: skip
COORDINATE = ("qpos0", "qpos_spring")
VELOCITY = ("dof_armature", "dof_damping")
#: Least mass and moment of inertia that MuJoCo takes [kg], [kg m^2].
LEAST = 1e-15


class Named(NamedTuple):
    """A body or joint by its name."""

    id: int
    name: str


@dataclass(eq=False)
class JoinedModel:
    """Trees of bodies under a world body; attributes and methods are those of `mujoco.MjModel`.

    `body_parentid` (nbody,) to `body_inertia` (nbody, 3), `jnt_type` (njnt,) to `jnt_range`
    (njnt, 2), `qpos0` and `qpos_spring` (nq,), `dof_armature` and `dof_damping` (nv,).
    """

    arrays: dict[str, NDArray[Any]]
    body_names: tuple[str, ...]
    joint_names: tuple[str, ...]

    def __post_init__(self) -> None:
        self._body = {name: i for i, name in enumerate(self.body_names)}
        self._joint = {name: i for i, name in enumerate(self.joint_names)}

    def __getattr__(self, name: str) -> NDArray[Any]:
        try:
            array: NDArray[Any] = vars(self)["arrays"][name]
            return array
        except KeyError:
            raise AttributeError(f"a JoinedModel has no {name!r}") from None

    @property
    def nbody(self) -> int:
        return len(self.body_names)

    @property
    def njnt(self) -> int:
        return len(self.joint_names)

    @property
    def nq(self) -> int:
        return len(self.arrays["qpos0"])

    @property
    def nv(self) -> int:
        return len(self.arrays["dof_armature"])

    def body(self, key: str | int) -> Named:
        """A body by name or number. Raises `KeyError` for an unknown name."""
        return _named(self._body, self.body_names, key)

    def joint(self, key: str | int) -> Named:
        """A joint by name or number. Raises `KeyError` for an unknown name."""
        return _named(self._joint, self.joint_names, key)


def _named(numbers: Mapping[str, int], names: Sequence[str], key: str | int) -> Named:
    return Named(numbers[key], key) if isinstance(key, str) else Named(key, names[key])


class Tree(NamedTuple):
    """Trees of bodies as `JoinedModel.arrays`, numbered from 0; parent -1: the world."""

    arrays: Mapping[str, NDArray[Any]]
    body_names: tuple[str, ...]
    joint_names: tuple[str, ...]


def join_model(
    bodies: Sequence[Body],
    people: Sequence[str],
    scene: Scene,
    held: Mapping[str, Hold],
    armature: Array,
) -> JoinedModel:
    """What `compile_model` makes of the same arguments, without geoms and without MuJoCo's types.

    Raises:
        ValueError: MuJoCo refuses a mass or an inertia.
    """
    trees = [
        _person_tree(body.variant, f"{name}/", armature)
        for name, body in zip(people, bodies, strict=True)
    ]
    for name, item in scene.objects.items():
        hold = held.get(name)
        if hold is None:
            trees.append(_object_tree(item))
        else:  # a body of the person's tree
            part = f"{people[hold.person]}/{hold.part}"
            trees[hold.person] = _holding(trees[hold.person], part, item, hold)
    return joined(trees + [_articulated_tree(item) for item in scene.articulated.values()])


def join_beside(
    model: Any, bodies: NDArray[np.int64], people: Mapping[str, Body], armature: Array
) -> JoinedModel:
    """Trees of a compiled `mujoco.MjModel`, then those of people.

    Args:
        model: Its joints and coordinates keep their numbers.
        bodies: Ids of its bodies (n,), rising, but the world's; those left out have neither
            joints nor children. They become bodies 1 to n.
        people: Prefix of the names of a person's bodies -> the person's body.
        armature: Of the people's joints (55,) [kg m^2].
    """
    whole, kept = _tree_of(model), bodies - 1
    number = np.full(model.nbody, -1)
    number[bodies] = np.arange(len(bodies))
    arrays = {k: v[kept] if k in BODY else v for k, v in whole.arrays.items()}
    arrays["body_parentid"] = number[arrays["body_parentid"] + 1]
    arrays["jnt_bodyid"] = number[arrays["jnt_bodyid"] + 1]
    host = Tree(arrays, tuple(whole.body_names[i] for i in kept), whole.joint_names)
    trees = [_person_tree(body.variant, prefix, armature) for prefix, body in people.items()]
    return joined([host, *trees])


def joined(trees: Iterable[Tree]) -> JoinedModel:
    """Trees under one world body, in their order."""
    parts = [_WORLD]
    body, joint, coordinate, velocity = 1, 0, 0, 0
    names: tuple[str, ...] = ("world",)
    joints: tuple[str, ...] = ()
    for tree in trees:
        a = dict(tree.arrays)
        a["body_parentid"] = np.where(a["body_parentid"] < 0, 0, a["body_parentid"] + body)
        for key, shift in (("body_jntadr", joint), ("body_dofadr", velocity)):
            a[key] = np.where(a[key] < 0, -1, a[key] + shift)
        a["jnt_bodyid"] = a["jnt_bodyid"] + body
        a["jnt_qposadr"] = a["jnt_qposadr"] + coordinate
        a["jnt_dofadr"] = a["jnt_dofadr"] + velocity
        parts.append(a)
        names, joints = names + tree.body_names, joints + tree.joint_names
        body, joint = len(names), len(joints)
        coordinate += len(a["qpos0"])
        velocity += len(a["dof_armature"])
    arrays = {key: np.concatenate([part[key] for part in parts]) for key in _WORLD}
    return JoinedModel(arrays, names, joints)


def _tree_of(model: Any) -> Tree:
    """All trees of a compiled `mujoco.MjModel`."""
    arrays = {key: np.array(getattr(model, key)[1:]) for key in BODY}
    arrays |= {key: np.array(getattr(model, key)) for key in JOINT + COORDINATE + VELOCITY}
    # The first of MuJoCo's numbers per power of the distance or velocity.
    for key, count in (("jnt_stiffness", model.njnt), ("dof_damping", model.nv)):
        arrays[key] = arrays[key].reshape(count, -1)[:, 0] if count else np.zeros(0)
    arrays["body_parentid"] = arrays["body_parentid"] - 1
    arrays["jnt_bodyid"] = arrays["jnt_bodyid"] - 1
    return Tree(
        {key: _plain(array) for key, array in arrays.items()},
        tuple(model.body(i).name for i in range(1, model.nbody)),
        tuple(model.joint(i).name for i in range(model.njnt)),
    )


def _plain(array: NDArray[Any]) -> NDArray[Any]:
    """As int32 or float64, read-only."""
    plain = np.ascontiguousarray(array, np.float64 if array.dtype.kind == "f" else np.int32)
    plain.setflags(write=False)
    return plain


_people: WeakKeyDictionary[Variant, Tree] = WeakKeyDictionary()


def _person_tree(variant: Variant, prefix: str, armature: Array) -> Tree:
    """A person's parts, made once; names and armatures are the caller's."""
    tree = _people.get(variant)
    if tree is None:
        tree = _people[variant] = _made_person(variant)
    joint = [JOINT_NAMES.index(name) for name in tree.joint_names]
    arrays = dict(tree.arrays)
    arrays["dof_armature"] = np.concatenate([np.zeros(6), np.repeat(armature[joint[1:]], 3)])
    names = tuple(prefix + name for name in tree.body_names)
    return Tree(arrays, names, tuple(prefix + name for name in tree.joint_names))


def _made_person(variant: Variant) -> Tree:
    """A free root and 54 ball joints, numbered depth first."""
    order = _depth_first()
    parts = [variant.parts[i] for i in order]
    place = np.argsort(order)  # of every joint among the bodies
    moments, turns = zip(*(principal(part.inertia) for part in parts), strict=True)
    mass = np.array([part.mass for part in parts])
    if any(not acceptable(m, i) for m, i in zip(mass, moments, strict=True)):
        return _compiled_person(variant)  # its words for what is wrong
    number = np.arange(N_JOINTS)
    position = np.array([variant.joint_offsets[i] for i in order])
    position[0] = (0.0, 0.0, variant.standing_height)
    turn = np.tile(_NO_TURN, (N_JOINTS, 1))
    turn[0] = UPRIGHT
    start = np.concatenate([position[0], UPRIGHT, np.tile(_NO_TURN[0], N_JOINTS - 1)])
    arrays = {
        "body_parentid": np.array([-1, *(place[PARENTS[i]] for i in order[1:])]),
        "body_jntadr": number,
        "body_jntnum": np.ones(N_JOINTS),
        "body_dofadr": 3 * number + 3 * (number > 0),
        "body_dofnum": np.where(number > 0, 3, 6),
        "jnt_type": (number > 0),
        "jnt_qposadr": 4 * number + 3 * (number > 0),
        "jnt_dofadr": 3 * number + 3 * (number > 0),
        "jnt_bodyid": number,
        "jnt_limited": np.zeros(N_JOINTS),
    }
    floats = {
        "body_pos": position,
        "body_quat": turn,
        "body_ipos": np.array([part.com for part in parts]),
        "body_iquat": np.array(turns),
        "body_mass": mass,
        "body_inertia": np.array(moments),
        "jnt_pos": np.zeros((N_JOINTS, 3)),
        "jnt_axis": np.tile((0.0, 0.0, 1.0), (N_JOINTS, 1)),
        "jnt_stiffness": np.zeros(N_JOINTS),
        "jnt_range": np.zeros((N_JOINTS, 2)),
        "qpos0": start,
        "qpos_spring": start,
        "dof_armature": np.zeros(3 * N_JOINTS + 3),
        "dof_damping": np.zeros(3 * N_JOINTS + 3),
    }
    names = tuple(JOINT_NAMES[i] for i in order)
    ints = {key: array.astype(np.int32) for key, array in arrays.items()}
    return Tree({key: _plain(array) for key, array in (ints | floats).items()}, names, names)


def _depth_first() -> list[int]:
    """Joints in the order of MuJoCo's bodies."""
    order: list[int] = []
    waiting = [0]
    while waiting:
        joint = waiting.pop()
        order.append(joint)
        waiting += [j for j in range(N_JOINTS - 1, 0, -1) if PARENTS[j] == joint]
    return order


def _compiled_person(variant: Variant) -> Tree:
    import mujoco

    from halfphysics.body.mjcf_person import add_person

    spec = mujoco.MjSpec()
    add_person(spec, variant, armature=np.zeros(N_JOINTS), geoms=False)
    return _tree_of(spec.compile())


def _object_tree(item: Object) -> Tree:
    """A body with a free joint."""
    given = isinstance(item, KinematicObject)  # its mass is never asked for
    mass, inertia = (1.0, np.eye(3)) if given else (float(item.mass), item.inertia)
    moments, turn = object_inertia(mass, np.asarray(inertia, dtype=np.float64).tobytes())
    start = np.concatenate([item.position, (1.0, 0.0, 0.0, 0.0)])
    arrays = dict(_FREE)
    arrays["body_pos"] = start[None, :3]
    arrays["body_mass"] = np.array([mass])
    arrays["body_inertia"], arrays["body_iquat"] = moments[None], turn[None]
    arrays["qpos0"] = arrays["qpos_spring"] = start
    return Tree(arrays, (f"object/{item.name}",), ("",))


def _holding(tree: Tree, part: str, item: Object, hold: Hold) -> Tree:
    """A person's tree with an object as the last child of a part: a body without a joint."""
    moments, turn = object_inertia(
        float(item.mass), np.asarray(item.inertia, dtype=np.float64).tobytes()
    )
    a, holder = dict(tree.arrays), tree.body_names.index(part)
    end = holder + 1
    while end < len(tree.body_names) and a["body_parentid"][end] >= holder:
        end += 1
    for key in ("body_parentid", "jnt_bodyid"):  # those from there on are one further
        a[key] = np.where(a[key] >= end, a[key] + 1, a[key])
    row: dict[str, Any] = {
        "body_parentid": holder,
        **{key: -1 for key in ("body_jntadr", "body_dofadr")},
        **{key: 0 for key in ("body_jntnum", "body_dofnum")},
        "body_pos": hold.position,
        "body_quat": hold.quaternion,
        "body_ipos": _NOWHERE[0],
        "body_iquat": turn,
        "body_mass": item.mass,
        "body_inertia": moments,
    }
    for key in BODY:
        a[key] = np.insert(a[key], end, row[key], axis=0)
    names = (*tree.body_names[:end], f"object/{item.name}", *tree.body_names[end:])
    return Tree(a, names, tree.joint_names)


@lru_cache(maxsize=1024)
def object_inertia(mass: float, inertia: bytes) -> tuple[Array, Array]:
    """Moments (3,) [kg m^2] and quaternion (4,) of an object's body as MuJoCo has them.

    Args:
        mass: [kg].
        inertia: The bytes of its inertia (3, 3) [kg m^2].

    Raises:
        InputError: MuJoCo refuses them: too small or too large, or no solid has them.
    """
    matrix = np.frombuffer(inertia).reshape(3, 3)
    moments, turn = principal(matrix)
    if not acceptable(mass, moments):
        try:
            moments, turn = compiled_inertia(mass, matrix)  # its words for what is wrong
        except ValueError as error:
            raise InputError(
                f"an object: found a mass of {mass:g} kg with moments of {moments} kg m^2, "
                f"expected those of a solid: {str(error).splitlines()[0]}. Change its size or mass"
            ) from None
    moments.setflags(write=False)
    turn.setflags(write=False)
    return moments, turn


def acceptable(mass: float, moments: Array) -> bool:
    """Whether MuJoCo takes a mass [kg] and moments (3,) [kg m^2], rising: those of a solid."""
    return bool(mass >= LEAST and moments[0] >= LEAST and moments[0] + moments[1] >= moments[2])


_articulated: WeakKeyDictionary[Articulated, tuple[bytes, Tree]] = WeakKeyDictionary()


def _articulated_tree(item: Articulated) -> Tree:
    """Links, compiled once as long as none of their numbers changes."""
    content = content_of(item)
    known = _articulated.get(item)
    if known is None or known[0] != content:
        known = _articulated[item] = content, _compiled_links(item)
    return known[1]


def content_of(item: Articulated) -> bytes:
    """All that the model of an articulated object is made of."""
    words: list[Any] = [item.name, len(item.links)]
    numbers: list[Any] = [item.position, item.quaternion]
    for link in item.links:
        words += [link.parent, link.mass, len(link.joints)]
        numbers += [link.position, link.quaternion, link.com, link.inertia, link.inertia_quaternion]
        for joint in link.joints:
            words += [joint.kind, joint.reference, joint.lower, joint.upper, joint.damping]
            words += [joint.stiffness, joint.springref, joint.armature]
            numbers += [joint.position, joint.axis]
    flat = np.concatenate([np.ravel(np.asarray(n, dtype=np.float64)) for n in numbers])
    return repr(words).encode() + flat.tobytes()


def _compiled_links(item: Articulated) -> Tree:
    import mujoco

    from halfphysics.scene.articulated import add_bodies

    spec = mujoco.MjSpec()
    add_bodies(spec, item)
    return _tree_of(spec.compile())


def _row(*values: float) -> Array:
    return np.array([values], dtype=np.float64)


def _of_ints(value: int) -> NDArray[np.int32]:
    return np.array([value], dtype=np.int32)


_NO_TURN = _row(1.0, 0.0, 0.0, 0.0)
_NOWHERE = _row(0.0, 0.0, 0.0)
#: The world body, and no joint.
_WORLD: Mapping[str, NDArray[Any]] = {
    "body_parentid": _of_ints(0),
    "body_jntadr": _of_ints(-1),
    "body_jntnum": _of_ints(0),
    "body_dofadr": _of_ints(-1),
    "body_dofnum": _of_ints(0),
    "body_pos": _NOWHERE,
    "body_quat": _NO_TURN,
    "body_ipos": _NOWHERE,
    "body_iquat": _NO_TURN,
    "body_mass": np.zeros(1),
    "body_inertia": _NOWHERE,
    **{key: np.zeros(0, dtype=np.int32) for key in JOINT},
    "jnt_pos": np.zeros((0, 3)),
    "jnt_axis": np.zeros((0, 3)),
    "jnt_stiffness": np.zeros(0),
    "jnt_range": np.zeros((0, 2)),
    **{key: np.zeros(0) for key in COORDINATE + VELOCITY},
}
#: A body with a free joint; its place, mass and inertia are to be filled in.
_FREE: Mapping[str, NDArray[Any]] = {
    "body_parentid": _of_ints(-1),
    "body_jntadr": _of_ints(0),
    "body_jntnum": _of_ints(1),
    "body_dofadr": _of_ints(0),
    "body_dofnum": _of_ints(6),
    "body_quat": _NO_TURN,
    "body_ipos": _NOWHERE,
    "jnt_type": _of_ints(0),
    "jnt_qposadr": _of_ints(0),
    "jnt_dofadr": _of_ints(0),
    "jnt_bodyid": _of_ints(0),
    "jnt_pos": _NOWHERE,
    "jnt_axis": _row(0.0, 0.0, 1.0),
    "jnt_stiffness": np.zeros(1),
    "jnt_limited": _of_ints(0),
    "jnt_range": _row(0.0, 0.0),
    "dof_armature": np.zeros(6),
    "dof_damping": np.zeros(6),
}
