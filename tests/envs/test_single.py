"""The face of gymnasium.make: its checker, seeds, pictures, mistakes."""

import copy
import pickle
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import halfphysics.envs
from halfphysics.envs import policies
from halfphysics.envs.tasks import names
from halfphysics.errors import InputError


@pytest.mark.parametrize("task", names())
def test_gymnasium_has_nothing_to_say(task):
    env = gymnasium.make(f"halfphysics/{task}-v0", size=(64, 48))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.mark.parametrize("task", names())
def test_the_same_seed_is_the_same_episode(task):
    def run(env, seed):
        seen, _ = env.reset(seed=seed)
        rows = [seen]
        chance = np.random.default_rng(1)
        for _ in range(12):
            action = chance.uniform(-1, 1, env.action_space.shape)
            rows.append(np.append(*env.step(action)[:2]).astype(np.float64))
        return b"".join(row.tobytes() for row in rows)

    env = gymnasium.make(f"halfphysics/{task}-v0")
    first = run(env, 3)
    assert run(env, 4) != first
    assert run(env, 3) == first


#: Steps into an episode after which the person walks; in HandOver it holds the cup before.
UNDER_WAY = 60


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("task", names())
def test_a_copy_goes_on_by_itself(task, copied):
    """The same bits as the original, in the middle of an episode and in the one after it."""
    env, policy = gymnasium.make(f"halfphysics/{task}-v0").unwrapped, policies.scripted(task)
    seen, _ = env.reset(seed=3)
    for _ in range(UNDER_WAY):
        if not env.task.worlds.holds(0, "cup"):
            seen = env.step(policy(seen[None])[0])[0]
    assert env.task.worlds.holds(0, "cup") == (task == "HandOver")
    other = copied(env)
    first = []
    while len(first) < 10 and not env.task.over[0]:
        first.append((policy(seen[None])[0], env.step(policy(seen[None])[0])))
        seen = first[-1][1][0]
    for action, expected in first:
        found = other.step(action)
        np.testing.assert_array_equal(found[0], expected[0])
        assert found[1:] == expected[1:]
    np.testing.assert_array_equal(other.reset()[0], env.reset()[0])


def test_seeds_of_numpy_are_seeds():
    env = gymnasium.make("halfphysics/Corridor-v0").unwrapped
    np.testing.assert_array_equal(env.reset(seed=np.int64(3))[0], env.reset(seed=3)[0])
    for seed in (-1, 1.5, "a", True):
        with pytest.raises(InputError, match="seed: found"):
            env.reset(seed=seed)


def test_without_a_seed_chance_goes_on():
    env = gymnasium.make("halfphysics/HandOver-v0")
    a, b = env.reset()[0], env.reset()[0]
    assert not np.array_equal(a, b)


def test_a_picture_shows_the_person_and_the_robot():
    env = gymnasium.make("halfphysics/HandOver-v0", render_mode="rgb_array", size=(120, 90))
    env.reset(seed=1)
    picture = env.render()
    assert picture.shape == (90, 120, 3)
    assert picture.dtype == np.uint8
    colors = picture.reshape(-1, 3).astype(int)
    # The person's and the pedestal's colours are far from the floor's and the sky's greys.
    assert (np.ptp(colors, axis=1) > 60).mean() > 0.03
    # The person wears clothes, as in all pictures: nothing else is as dark and blue as trousers.
    red, green, blue = colors.T
    assert ((blue > red + 8) & (blue > green + 5) & (blue < 100)).sum() > 20
    assert np.array_equal(env.render(), picture)
    assert gymnasium.make("halfphysics/HandOver-v0").render_mode is None


def test_an_episode_ends_at_its_longest():
    env = gymnasium.make("halfphysics/HandOver-v0", steps=3)
    env.reset(seed=0)
    ends = [env.step(np.array([0.0, 0.0, 0.0, -1.0]))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]
    with pytest.raises(InputError, match="call reset"):
        env.unwrapped.step(np.zeros(4))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"render_mode": "human"}, "render_mode: found 'human'"),
        ({"render_mode": np.array(["rgb_array", None])}, r"render_mode: found array\("),
        ({"render_mode": ["rgb_array"]}, r"render_mode: found \['rgb_array'\]"),
        ({"task": "HandOvr"}, "'HandOver'"),
        ({"steps": 0}, "steps: found 0"),
    ],
)
def test_impossible_arguments(options, words):
    from halfphysics.envs.single import SingleEnv

    with pytest.raises(InputError, match=words):
        SingleEnv(**({"task": "HandOver"} | options))


def test_numpys_whole_numbers_are_sizes_and_steps():
    env = gymnasium.make(
        "halfphysics/HandOver-v0",
        steps=np.int64(1),
        size=(np.int32(32), np.uint8(24)),
        render_mode="rgb_array",
    ).unwrapped
    assert (env.size, type(env.size[0]), type(env.task.steps)) == ((32, 24), int, int)
    env.reset(seed=0)
    assert env.step(np.array([0.0, 0.0, 0.0, -1.0]))[3]
    assert env.render().shape == (24, 32, 3)


@pytest.mark.parametrize("action", [[0.0], "left", [0.0, 0.0, np.nan, 0.0], None])
def test_impossible_actions(action):
    env = gymnasium.make("halfphysics/HandOver-v0").unwrapped
    env.reset(seed=0)
    with pytest.raises(InputError, match="step: action"):
        env.step(action)


@pytest.mark.parametrize("size", [(0, 10), (10, 5000), (10,), 10, "ab", (1.5, 2), None])
def test_an_impossible_size_is_refused_when_an_environment_is_made(size):
    """By all three faces, whether they will render or not."""
    for make in (
        lambda: gymnasium.make("halfphysics/HandOver-v0", size=size),
        lambda: gymnasium.make_vec("halfphysics/HandOver-v0", 1, size=size),
        lambda: halfphysics.envs.parallel_env("HandOver", size=size),
    ):
        with pytest.raises(InputError, match="size: found"):
            make()


@pytest.mark.parametrize("task", names())
def test_actions_beyond_their_range_are_cut_off(task):
    """1e300 is the largest action there is, bit for bit, and harms nothing."""

    def run(action):
        env = gymnasium.make(f"halfphysics/{task}-v0").unwrapped
        said = [env.reset(seed=3)[0].tobytes()]
        for sign in (1.0, -1.0, 1.0):
            seen, reward, *_ = env.step(np.full(env.action_space.shape, sign * action))
            said += [seen.tobytes(), reward]
        return said

    assert run(1e300) == run(1.0)


def test_registering_again_does_no_harm_and_a_module_in_the_name_is_enough():
    halfphysics.envs.register()
    assert "halfphysics/HandOver-v0" in gymnasium.registry
    code = (
        "import gymnasium; e = gymnasium.make('halfphysics.envs:halfphysics/Corridor-v0');"
        "print(e.reset(seed=0)[0].shape)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "(15,)"
