"""The face of gymnasium.make_vec: the same bytes as single environments, at any threads."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import halfphysics.envs  # noqa: F401 - registers
from halfphysics.envs import policies
from halfphysics.envs.tasks import names
from halfphysics.errors import InputError
from support.paths import ROOT

#: Steps that see a hand-over through, from the first reach to the cup's last touch.
STEPS = 75


def told(task, steps, count):
    """Actions by a seed (steps, count, A)."""
    size = gymnasium.spec(f"halfphysics/{task}-v0").make().action_space.shape[0]
    return np.random.default_rng(5).uniform(-1, 1, (steps, count, size))


def bytes_of(env, actions, seed):
    """Everything that an environment says while actions are taken."""
    seen, _ = env.reset(seed=seed)
    said = [seen.tobytes()]
    for action in actions:
        seen, reward, ended, late, info = env.step(action)
        said += [seen.tobytes(), np.asarray(reward).tobytes(), ended.tobytes(), late.tobytes()]
        said += [np.asarray(info[name]).tobytes() for name in sorted(info)]
    return b"".join(said)


@pytest.mark.parametrize("task", names())
def test_every_number_of_threads_gives_the_same_bytes(task):
    actions = told(task, 25, 3)
    one, two, eight = (
        bytes_of(gymnasium.make_vec(f"halfphysics/{task}-v0", 3, threads=threads), actions, 11)
        for threads in (1, 2, 8)
    )
    assert one == two == eight


@pytest.mark.parametrize("task", names())
def test_every_episode_is_that_of_a_single_environment(task):
    """By script, through grasps, pushes and ends: observations and rewards, bit for bit."""
    count, policy = 3, policies.scripted(task)
    many = gymnasium.make_vec(f"halfphysics/{task}-v0", count, threads=2)
    singles = [gymnasium.make(f"halfphysics/{task}-v0").unwrapped for _ in range(count)]
    seen, _ = many.reset(seed=21)
    alone = [env.reset(seed=21 + i)[0] for i, env in enumerate(singles)]
    over = np.zeros(count, dtype=bool)
    for _ in range(STEPS):
        assert np.array_equal(seen, np.stack(alone))
        actions = policy(seen)
        seen, reward, ended, late, _ = many.step(actions)
        for i, env in enumerate(singles):
            if over[i]:
                alone[i], own = env.reset()[0], 0.0
                over[i] = False
            else:
                alone[i], own, end, out, _ = env.step(actions[i])
                over[i] = end or out
                assert (end, out) == (ended[i], late[i])
            assert own == reward[i]


def test_episodes_begin_again_by_themselves():
    env = gymnasium.make_vec("halfphysics/HandOver-v0", 2, threads=1, steps=4)
    env.reset(seed=1)
    lates = []
    for _ in range(7):
        *_, late, info = env.step(np.tile([0.0, 0.0, 0.0, -1.0], (2, 1)))
        lates.append(late.tolist())
    assert lates == [[i == 3] * 2 for i in range(7)]
    assert info["_success"].all()


def test_in_the_same_step_if_wanted():
    env = gymnasium.make_vec(
        "halfphysics/HandOver-v0", 2, threads=1, steps=2, autoreset_mode=AutoresetMode.SAME_STEP
    )
    env.reset(seed=1)
    act = np.tile([0.0, 0.0, 0.0, -1.0], (2, 1))
    env.step(act)
    seen, _, _, late, info = env.step(act)
    assert late.all()
    assert info["_final_obs"].all()
    assert info["final_obs"][0][-1] == 1.0  # all of the episode had passed
    assert seen[0, -1] == 0.0
    assert not env.step(act)[3].any()


def known(info, i):
    """What a vector environment's info says of episode i, by gymnasium's masks."""
    of = {name: value for name, value in info.items() if f"_{name}" in info and info[f"_{name}"][i]}
    return {
        name: known(value, i) if isinstance(value, dict) else np.asarray(value[i]).tolist()
        for name, value in of.items()
    }


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_infos_say_of_each_episode_what_those_of_gymnasium_do(mode):
    """One of two episodes begins a step later, so that they end apart."""
    name, steps = "halfphysics/Corridor-v0", 3
    ours = gymnasium.make_vec(name, 2, threads=1, steps=steps, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: gymnasium.make(name, steps=steps)] * 2, autoreset_mode=mode)
    act = np.full((2, 2), 0.4, dtype=np.float32)
    for env in (ours, theirs):
        env.reset(seed=2)
        env.step(act)
    ours.reset(options={"reset_mask": np.array([True, False])})
    theirs.envs[0].reset()
    ends = []
    for _ in range(5):
        found, expected = ours.step(act), theirs.step(act)
        for i in range(2):
            assert known(found[4], i) == known(expected[4], i)
        ends.append(found[3].tolist())
    assert [False, True] in ends
    assert [True, False] in ends


def test_some_of_them_begin_by_a_mask():
    env = gymnasium.make_vec(
        "halfphysics/HandOver-v0", 2, threads=1, steps=2, autoreset_mode=AutoresetMode.DISABLED
    )
    env.reset(seed=1)
    act = np.tile([0.0, 0.0, 0.0, -1.0], (2, 1))
    env.step(act)
    env.step(act)
    with pytest.raises(InputError, match="0, 1 are over"):
        env.step(act)
    env.reset(seed=[4, None], options={"reset_mask": np.array([True, False])})
    assert env.task.over.tolist() == [False, True]


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_modes_have_the_names_that_the_document_has(mode):
    assert f'"{mode}"' in (ROOT / "docs" / "envs.md").read_text(encoding="utf-8")
    many = gymnasium.make_vec("halfphysics/HandOver-v0", 1, threads=1, autoreset_mode=mode)
    assert many.metadata["autoreset_mode"].value == mode


def test_numpys_whole_numbers_are_numbers_of_environments_and_threads():
    env = gymnasium.make_vec("halfphysics/HandOver-v0", np.int64(2), threads=np.int32(1))
    assert (env.num_envs, type(env.num_envs), env.reset(seed=0)[0].shape[0]) == (2, int, 2)


def test_mistakes():
    make = gymnasium.make_vec
    with pytest.raises(InputError, match="num_envs: found 0"):
        make("halfphysics/HandOver-v0", 0)
    with pytest.raises(InputError, match="autoreset_mode"):
        make("halfphysics/HandOver-v0", 1, autoreset_mode="never")
    env = make("halfphysics/HandOver-v0", 2, threads=1)
    with pytest.raises(InputError, match="call reset"):
        env.step(np.zeros((2, 4)))
    for seed in ([1], ["a", "b"], [1.5, 2.0], [-1, 0], -1):
        with pytest.raises(InputError, match="seed: found"):
            env.reset(seed=seed)
    first = env.reset(seed=3)[0]
    for seed in (np.int64(3), np.array([3, 4])):
        np.testing.assert_array_equal(env.reset(seed=seed)[0], first)
    env = make("halfphysics/HandOver-v0", 2, threads=1)
    for mask in (np.array([1, 0]), [[1], [1, 2]], None, [True]):
        with pytest.raises(InputError, match=r"reset_mask: found .*expected 2 times"):
            env.reset(options={"reset_mask": mask})
    with pytest.raises(InputError, match="'reset_mask' only"):
        env.reset(options={"mode": 1})
    with pytest.raises(InputError, match="options: found 5, expected a dict"):
        env.reset(options=5)
    env.reset(seed=0)
    with pytest.raises(InputError, match="step: action"):
        env.step(np.zeros((3, 4)))


def test_pictures_of_all():
    env = gymnasium.make_vec(
        "halfphysics/Corridor-v0", 2, threads=1, render_mode="rgb_array", size=(40, 30)
    )
    env.reset(seed=0)
    pictures = env.render()
    assert [p.shape for p in pictures] == [(30, 40, 3)] * 2
    assert not np.array_equal(*pictures)
