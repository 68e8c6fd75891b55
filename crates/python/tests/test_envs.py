"""The environments of Gymnasium."""

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import ppnpack
import ppnpack.envs

ID = "ppnpack/Packing-v0"


def first(mask):
    return int(mask.argmax())


def play(env, choose, **reset):
    """Plays an episode; gives the rewards and the last information."""
    observation, info = env.reset(**reset)
    rewards, terminated = [], False
    while not terminated:
        assert observation in env.observation_space
        observation, reward, terminated, truncated, info = env.step(choose(observation["action_mask"]))
        assert not truncated
        rewards.append(reward)
    return rewards, info


@pytest.mark.parametrize("physics", [False, True])
def test_the_checker_finds_nothing(physics):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(ID, physics=physics, buffer=2, items=6)
        check_env(env.unwrapped)


@pytest.mark.parametrize("physics", [False, True])
def test_rewards_add_up_to_the_packed_share(grid, catalogue, physics):
    env = gymnasium.make(ID, grid=grid, catalogue=catalogue, items=15, physics=physics)
    rng = np.random.default_rng(7)
    rewards, info = play(env, lambda mask: rng.choice(np.flatnonzero(mask)), seed=3)
    assert info["is_valid"] and info["packed"] <= 15
    assert sum(rewards) == pytest.approx(info["volume_share"])
    if not physics:
        assert min(rewards) > 0 and info["packed"] == len(rewards)


def test_the_same_seed_is_the_same_episode_and_another_is_not(grid, catalogue):
    env = gymnasium.make(ID, grid=grid, catalogue=catalogue, items=12)
    one, other, third = (play(env, first, seed=seed)[0] for seed in (1, 1, 2))
    assert one == other and one != third


@pytest.mark.parametrize("settings", [{}, {"physics": True, "camera": {}}])
def test_the_same_seed_is_the_same_episode_alone_and_in_vectors(grid, catalogue, settings):
    settings = {"grid": grid, "catalogue": catalogue, "items": 4, **settings}
    vector = gymnasium.make_vec(ID, num_envs=2, **settings)
    sync = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make(ID, **settings)] * 2)
    alone = [gymnasium.make(ID, **settings) for _ in range(2)]
    for seed in (9, [9, 10], 9):
        seen = [vector.reset(seed=seed)[0], sync.reset(seed=seed)[0]]
        single = [env.reset(seed=9 + number)[0] for number, env in enumerate(alone)]
        for _ in range(9):
            for name in ("heightmap", "item_top", "action_mask"):
                each = np.stack([observation[name] for observation in single])
                assert np.array_equal(seen[0][name], each) and np.array_equal(seen[1][name], each)
            actions = seen[0]["action_mask"].argmax(1)
            seen = [envs.step(actions)[0] for envs in (vector, sync)]
            single = [
                env.reset()[0] if not observation["action_mask"].any() else env.step(action)[0]
                for env, observation, action in zip(alone, single, actions, strict=True)
            ]


# What a test of its own process runs: a fork of this one would have the threads of other tests.
FORKED = """
import os, warnings
import gymnasium, numpy as np
import ppnpack, ppnpack.envs
warnings.simplefilter("ignore", DeprecationWarning)
grid = ppnpack.Grid.reference()
pooled = ppnpack.Packings(grid, ppnpack.Catalogue(grid), 2, threads=2)
envs = gymnasium.make_vec("ppnpack/Packing-v0", num_envs=2, vectorization_mode="async", vector_kwargs={"context": "fork"}, items=3)
observation, _ = envs.reset(seed=1)
envs.step(observation["action_mask"].argmax(1))
envs.close()
child = os.fork()
if child == 0:
    try:
        pooled.reset([1, 2])
    except RuntimeError as error:
        os._exit(7 if "make it after the fork" in str(error) else 8)
    os._exit(9)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
print("done")
"""


def test_forked_processes_work_or_say_why_not():
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "done", done.stdout + done.stderr


@pytest.mark.parametrize("physics", [False, True])
def test_the_container_is_drawn_and_heights_stay_within_the_space(grid, catalogue, physics):
    env = gymnasium.make(ID, grid=grid, catalogue=catalogue, items=3, physics=physics, render_mode="rgb_array")
    observation, _ = env.reset(seed=1)
    empty = env.render()
    assert empty.shape == (480, 640, 3) and empty.dtype == np.uint8
    env.step(first(observation["action_mask"]))
    assert (env.render() != empty).any()
    highest = int(env.observation_space["heightmap"].high.max())
    assert grid.rim <= highest <= 3 * grid.rim
    vector = ppnpack.envs.VectorPackingEnv(2, grid, catalogue, render_mode="rgb_array")
    vector.reset(seed=1)
    assert [picture.shape for picture in vector.render()] == [(480, 640, 3)] * 2
    assert ppnpack.envs.PackingEnv(grid, catalogue).render() is None


def test_actions_are_slot_yaw_x_y(grid, catalogue):
    env = ppnpack.envs.PackingEnv(grid, catalogue, buffer=2, items=4)
    mug, bowl = catalogue.names.index("mug"), catalogue.names.index("bowl")
    observation, info = env.reset(options={"objects": [mug, bowl, mug]})
    assert info["objects"].tolist() == [mug, bowl]
    heights = ppnpack.resting_heights(grid, grid.empty(), catalogue["bowl"])
    assert np.array_equal(observation["action_mask"].reshape(env.action_shape)[1], heights >= 0)
    top, bottom = catalogue["bowl"].top(2), catalogue["bowl"].bottom(2)
    seen = tuple(slice(side) for side in top.shape)
    assert np.array_equal(observation["item_top"][1, 2][seen], top)
    assert np.array_equal(observation["item_bottom"][1, 2][seen], bottom)
    assert observation["item_bottom"][1, 2].max() == bottom.max() and (observation["item_bottom"] >= -1).all()
    assert np.array_equal(env.action_masks(), observation["action_mask"] == 1)

    action = int(np.ravel_multi_index((1, 2, 3, 4), env.action_shape))
    observation, reward, terminated, _, info = env.step(action)
    expected = ppnpack.place(grid.empty(), catalogue["bowl"], ppnpack.Placement(2, 3, 4, 0))
    assert np.array_equal(observation["heightmap"], expected) and not terminated
    assert reward == pytest.approx(catalogue["bowl"].mesh_volume_m3 / grid.volume_m3)
    # The slot is taken by what arrives next; then there is nothing left for it.
    assert info["objects"].tolist() == [mug, mug]
    observation, *_, info = env.step(first(observation["action_mask"]))
    assert info["objects"].tolist() == [-1, mug]
    assert not observation["action_mask"].reshape(env.action_shape)[0].any()
    assert (observation["item_bottom"][0] == -1).all()


def test_masks_are_exactly_what_fits_as_the_container_fills(grid, catalogue):
    """Resting heights are kept from step to step; that must not show."""
    env = ppnpack.envs.PackingEnv(grid, catalogue, items=40)
    rng = np.random.default_rng(8)
    observation, info = env.reset(seed=8)
    terminated = False
    while not terminated:
        masks = observation["action_mask"].reshape(env.action_shape)
        for slot, index in enumerate(info["objects"]):
            if index < 0:
                continue
            item = catalogue[int(index)]
            heights = ppnpack.resting_heights(grid, observation["heightmap"], item)
            tops = np.array([item.height(yaw) for yaw in range(4)])[:, None, None]
            assert np.array_equal(masks[slot] == 1, (heights >= 0) & (heights + tops <= grid.rim))
        action = rng.choice(np.flatnonzero(observation["action_mask"]))
        observation, _, terminated, _, info = env.step(action)
    assert not observation["action_mask"].any()


def test_published_stability_narrows_the_mask(grid, catalogue):
    env = ppnpack.envs.PackingEnv(grid, catalogue, buffer=1, stability="published")
    observation, info = env.reset(seed=4)
    item = catalogue[int(info["objects"][0])]
    stable = ppnpack.evaluate(grid, grid.empty(), item).stable
    assert np.array_equal(observation["action_mask"].reshape(stable.shape) == 1, stable)


def test_an_action_that_is_not_possible_ends_the_episode(grid, catalogue):
    env = ppnpack.envs.PackingEnv(grid, catalogue)
    observation, _ = env.reset(seed=1)
    impossible = int(np.flatnonzero(observation["action_mask"] == 0)[0])
    after, reward, terminated, _, info = env.step(impossible)
    assert terminated and reward == 0.0 and not info["is_valid"]
    assert np.array_equal(after["heightmap"], observation["heightmap"])
    with pytest.raises(ValueError, match="reset it"):
        env.step(0)
    env.reset()
    with pytest.raises(TypeError, match="whole numbers, not float64"):
        env.step(1.5)
    assert not env.step(-1)[4]["is_valid"]


def test_observations_are_the_callers_own(grid, catalogue):
    env = ppnpack.envs.PackingEnv(grid, catalogue)
    observation, _ = env.reset(seed=1)
    kept = {name: values.copy() for name, values in observation.items()}
    env.step(first(observation["action_mask"]))
    assert all(np.array_equal(observation[name], kept[name]) for name in kept)


@pytest.mark.parametrize("physics", [False, True])
def test_vectors_are_environments_side_by_side(grid, catalogue, physics):
    count, settings = 3, {"buffer": 2, "items": 5, "physics": physics}
    envs = gymnasium.make_vec(ID, num_envs=count, grid=grid, catalogue=catalogue, threads=2, **settings)
    assert envs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    observation, infos = envs.reset(seed=[10, 11, 12])
    singles = ppnpack.Packings(grid, catalogue, count, threads=1, **settings)
    alone = singles.reset([10, 11, 12])
    was_over = np.zeros(count, bool)
    resets = 0
    for _ in range(14):
        assert observation in envs.observation_space
        assert np.array_equal(observation["heightmap"], alone.heightmap)
        actions = observation["action_mask"].argmax(1)
        observation, reward, terminated, truncated, infos = envs.step(actions)
        alone, stepped = singles.step(actions, autoreset=True)
        assert np.array_equal(reward, stepped.reward) and np.array_equal(terminated, stepped.is_over)
        assert np.array_equal(stepped.was_reset, was_over) and not reward[was_over].any()
        assert (observation["heightmap"][was_over] == 0).all() and not truncated.any()
        resets += int(was_over.sum())
        was_over = terminated
    assert resets >= 3


def test_wrong_settings_are_refused(grid, catalogue):
    with pytest.raises(ValueError, match="stability is"):
        ppnpack.envs.PackingEnv(grid, catalogue, stability="some")
    with pytest.raises(ValueError, match="buffer must be between 1 and 256"):
        ppnpack.envs.PackingEnv(grid, catalogue, buffer=0)
    with pytest.raises(ValueError, match="another cell, height unit or yaws"):
        ppnpack.envs.PackingEnv(ppnpack.Grid(cell_m=0.02), catalogue)
    env = ppnpack.envs.PackingEnv(grid, catalogue)
    with pytest.raises(ValueError, match="'objects' alone, not reset_mask"):
        env.reset(options={"reset_mask": [True]})
    with pytest.raises(ValueError, match="'rgb_array' or none"):
        ppnpack.envs.PackingEnv(grid, catalogue, render_mode="human")
    with pytest.raises(ValueError, match="no object 96"):
        env.reset(options={"objects": [96]})
    assert env.reset(seed=1)
