"""Everything can be copied, pickled and sent to other processes, and comes back bit for bit."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from dataclasses import is_dataclass

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.copying import Bound, FrozenMapping
from halfphysics.labels import contact_labels
from halfphysics.results.simulated_scene import SimulatedScene
from halfphysics.support import Support
from support import small_results as small

METHODS = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "deepcopy": copy.deepcopy,
}


def leaves(value, path="", seen=None):
    """(path, leaf) of all that a value is made of, each object once."""
    seen = set() if seen is None else seen
    if isinstance(value, np.ndarray | str | bytes | int | float | bool | type(None)):
        yield path, value
    elif id(value) not in seen:
        seen.add(id(value))
        kept = seen, value  # ids of things that are gone are used again
        if isinstance(value, dict | FrozenMapping):
            for key, one in value.items():
                # A set is written in the order of its hashes, which a copy need not have.
                name = sorted(key) if isinstance(key, frozenset) else key
                yield from leaves(one, f"{path}[{name!r}]", seen)
        elif isinstance(value, list | tuple):
            for index, one in enumerate(value):
                yield from leaves(one, f"{path}[{index}]", seen)
        elif is_dataclass(value) or type(value).__module__.startswith("halfphysics"):
            rebuilt = getattr(value, "_REBUILT", frozenset())
            state = getattr(value, "__dict__", {})
            for key in sorted(set(state) - rebuilt):
                yield from leaves(state[key], f"{path}.{key}", seen)
        del kept


def same_leaf(a, b):
    if not isinstance(a, np.ndarray):
        return type(a) is type(b) and (a == b or a != a)
    alike = a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    return alike and (b.flags.writeable is False or a.flags.writeable)


def differences(a, b):
    """Paths at which two values differ: numbers, types, or an array that became writeable."""
    these, those = dict(leaves(a)), dict(leaves(b))
    assert these
    if these.keys() != those.keys():
        return sorted(these.keys() ^ those.keys())
    return [path for path, one in these.items() if not same_leaf(one, those[path])]


def used_result():
    """A result all of whose derived values were worked out."""
    result = small.result()
    result.parts(0), result.holds
    assert isinstance(result.people[1].support, Support)
    return result


def used_mesh():
    mesh = hp.Mesh(*small.WEDGE)
    mesh.query.depth(np.zeros((1, 3)))
    assert mesh.hull.closed
    return mesh


def loaded(tmp_path):
    small.alone().save(tmp_path / "out.npz")
    return hp.Result.load(tmp_path / "out.npz")


def sequence(_):
    return hp.scenarios.load("open_drawer")


THINGS = {
    "Result": lambda _: used_result(),
    "Result from a file": loaded,
    "PersonResult": lambda _: used_result().people[1],
    "Contacts": lambda _: small.result().contacts,
    "Inside": lambda _: small.result().inside,
    "Breaches": lambda _: small.result().breaches,
    "Substeps": lambda _: small.result().substeps,
    "ObjectTrack": lambda _: small.result().objects["box"],
    "diagnostics": lambda _: small.result().diagnostics,
    "Support": lambda _: used_result().people[1].support,
    "Motion": lambda _: small.motions()[0],
    "Pose": lambda _: small.motions()[0][3],
    "Body": lambda _: hp.Body.default(stature=1.8, mass=70.0),
    "Body as it was used": lambda _: used_result().people[0].body,
    "Scene": lambda _: small.scene(),
    "Scene as it was used": lambda _: used_result().scene,
    "Mesh": lambda _: used_mesh(),
    "Box": lambda _: hp.Box((1.0, 2.0, 3.0)),
    "Settings": lambda _: hp.Settings.paper(stiffness={"arms": 2.0}),
    "baseline": lambda _: hp.baselines.Torque(frequency=50.0),
    "Sequence": sequence,
    "Verdict": lambda _: hp.metrics.judge(small.motions()[0], hp.Body.default()),
    "deviation": lambda _: hp.metrics.deviation(small.alone()),
    "contact_forces": lambda _: hp.metrics.contact_forces(small.result()),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", THINGS)
def test_copies_are_equal_and_read_only(name, method, tmp_path):
    """Each number to the last bit, each type, and no array that could be written and was not."""
    thing = THINGS[name](tmp_path)
    assert differences(thing, METHODS[method](thing)) == []


def test_a_difference_would_be_found():
    motion = small.motions()[0]
    other = motion.with_frames(motion.translation + 1e-15, motion.rotations)
    assert differences(motion, other) == [".translation"]
    thawed = copy.deepcopy(motion)
    thawed.rotations.setflags(write=True)
    assert differences(motion, thawed) == [".rotations"]


def test_the_default_body_is_one_object_in_every_process():
    body = hp.Body.default()
    assert pickle.loads(pickle.dumps(body)) is body
    assert len(pickle.dumps(body)) < 200
    other = hp.Body.default(mass=80.0)
    assert pickle.loads(pickle.dumps(other)).mass == pytest.approx(80.0, abs=1e-9)


def test_a_result_from_a_file_stays_unloaded():
    """What is loaded on first access is loaded by who needs it."""
    record = vars(METHODS["pickle"](small.alone()))["_scene"]
    assert isinstance(record, SimulatedScene)
    assert isinstance(record.make(), hp.Scene)


def test_a_copied_result_answers(tmp_path):
    """Summary, parts and forces of a copy are those of the original."""
    result, again = small.alone(), METHODS["pickle"](small.alone())
    assert again.summary() == result.summary()
    assert np.array_equal(again.parts(0).clearance, result.parts(0).clearance)
    again.save(tmp_path / "again.npz")
    result.save(tmp_path / "result.npz")
    one, two = hp.Result.load(tmp_path / "again.npz"), hp.Result.load(tmp_path / "result.npz")
    assert differences(one.contacts, two.contacts) == []


def test_labels_leave_the_core_behind():
    labels = contact_labels(small.alone())
    again = METHODS["pickle"](labels)
    assert again.objects[0].grid is not labels.objects[0].grid
    assert np.array_equal(again.objects[0].vertices, labels.objects[0].vertices)


# -- other processes -----------------------------------------------------------------------------

TASKS = [(small.motions()[k], small.scene()) for k in (0, 1)]


def numbers(result):
    contacts = result.contacts
    return (
        result.motion.translation.tobytes() + result.motion.rotations.tobytes(),
        contacts.impulse.tobytes() + contacts.frame.tobytes() + contacts.part.tobytes(),
        result.objects["box"].position.tobytes(),
    )


@pytest.fixture(scope="module")
def here():
    return [numbers(hp.simulate(*task)) for task in TASKS]


@pytest.mark.parametrize("start", ["spawn", "fork"])
def test_a_pool_simulates(start, here):
    """The bits of a process that was started afresh or forked are those of this one."""
    with multiprocessing.get_context(start).Pool(1) as pool:
        found = pool.starmap(hp.simulate, TASKS)
    assert [numbers(result) for result in found] == here


def test_an_executor_simulates(here):
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        motions, scenes = zip(*TASKS, strict=True)
        found = list(executor.map(hp.simulate, motions, scenes))
    assert [numbers(result) for result in found] == here


# -- what lives in one process ---------------------------------------------------------------------


def test_what_cannot_be_sent_says_why():
    import mujoco

    spec = mujoco.MjSpec()
    human = hp.attach(spec)
    model = spec.compile()
    control = human.bind(model, mujoco.MjData(model))
    for act in (pickle.dumps, copy.deepcopy, copy.copy):
        with pytest.raises(TypeError, match=r"^Control: it cannot be copied or sent .*: it steps "):
            act(control)


def test_frozen_mappings():
    given = {"a": 1, "b": 2}
    kept = FrozenMapping(given)
    given["a"] = 3
    assert dict(kept) == {"a": 1, "b": 2}
    assert kept == {"a": 1, "b": 2}
    assert list(kept | {"c": 3}) == ["a", "b", "c"]
    assert {"c": 3} | kept == {"c": 3, "a": 1, "b": 2}
    assert repr(kept) == "{'a': 1, 'b': 2}"
    with pytest.raises(TypeError):
        kept["a"] = 5
    with pytest.raises(AttributeError, match="never changes"):
        kept._items = {}


def test_a_bound_class_has_a_reason():
    assert all(isinstance(kind._WHY, str) for kind in Bound.__subclasses__())
