"""The example of an environment of gymnasium, with a stand-in of what it uses of it where it is not installed."""

import contextlib
import io
import os
import pathlib
import sys
import types
import unittest

import numpy

import palpate

sys.path.insert(0, str(pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples")))


class Box:
    """gymnasium.spaces.Box of one low and high: https://gymnasium.farama.org/api/spaces/fundamental/#box"""

    def __init__(self, low, high, shape, dtype=numpy.float32):
        self.low, self.high, self.shape, self.dtype = low, high, shape, numpy.dtype(dtype)

    def contains(self, x):
        return x.dtype == self.dtype and x.shape == self.shape and bool(((x >= self.low) & (x <= self.high)).all())


class Env:
    """gymnasium.Env: https://gymnasium.farama.org/api/env/"""

    def reset(self, *, seed=None, options=None):
        if seed is not None or not hasattr(self, "np_random"):
            self.np_random = numpy.random.default_rng(seed)


try:
    import gymnasium
except ImportError:
    gymnasium = types.ModuleType("gymnasium")
    gymnasium.Env, gymnasium.spaces = Env, types.SimpleNamespace(Box=Box)
    sys.modules["gymnasium"] = gymnasium

import gym_env  # noqa: E402


class Environment(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.005}, leaves=1, start=[0, 0.1, 0])
        block = palpate.object("block", {"shape": "box", "size_m": [0.05, 0.05, 0.05]})
        cls.scene = palpate.scene(tools=[ball], objects=[block])

    def setUp(self):
        self.env = gym_env.PressEnv(self.scene)

    def test_keeps_gymnasiums_terms(self):
        observation, info = self.env.reset(seed=1)
        self.assertIsInstance(self.env, gymnasium.Env)
        self.assertTrue(self.env.observation_space.contains(observation))
        self.assertEqual((self.env.action_space.shape, info), ((3,), {}))
        observation, reward, terminated, truncated, info = self.env.step(numpy.zeros(3, numpy.float32))
        self.assertTrue(self.env.observation_space.contains(observation))
        self.assertEqual([type(each) for each in (reward, terminated, truncated, info)], [float, bool, bool, dict])
        for wrong in (numpy.zeros(4), [0, numpy.nan, 0], 0):
            with self.assertRaises(ValueError):
                self.env.step(wrong)

    def test_gives_the_same_bits_for_the_same_seed_and_actions_also_in_a_new_one(self):
        actions = numpy.random.default_rng(5).uniform(-1, 0.5, (60, 3)).astype(numpy.float32)

        def felt(env, seed):
            first, _ = env.reset(seed=seed)
            return first.tobytes() + b"".join(env.step(action)[0].tobytes() for action in actions)

        once = felt(self.env, 1)
        self.assertEqual(felt(self.env, 1), once)
        self.assertEqual(felt(gym_env.PressEnv(self.scene), 1), once)
        self.assertNotEqual(felt(self.env, 2), once)

    def test_rewards_the_wanted_force_and_ends_for_one_too_great_or_after_its_steps(self):
        self.env.reset(seed=1)
        self.env.hand = numpy.array([0, 0.030, 0])
        down, still = numpy.array([0, -1, 0]), numpy.zeros(3)
        rewards = [self.env.step(down)[1] for _ in range(2)]
        observation, reward, terminated, _, _ = self.env.step(still)
        numpy.testing.assert_allclose(observation[:3], [0, 2, 0], atol=0.02)  # 2 mm at 1 N for each
        numpy.testing.assert_allclose([*rewards, reward], [-1, 0, 0], atol=0.02)
        numpy.testing.assert_allclose(observation[3:], [0, 2, 0, 0, -4, 0], atol=0.02)
        self.assertFalse(terminated)
        ends = [self.env.step(down)[2] for _ in range(19)]
        self.assertEqual((ends[:17], ends[-1]), ([False] * 17, True))  # 19 N, and 21 N
        self.env.reset(seed=1)
        self.assertEqual([self.env.step(still)[3] for _ in range(200)], [False] * 199 + [True])

    def test_is_mastered_by_a_simple_rule(self):
        shown = io.StringIO()
        arguments, sys.argv = sys.argv, ["gym_env.py", "cube"]
        self.addCleanup(setattr, sys, "argv", arguments)
        with contextlib.redirect_stdout(shown):
            gym_env.main()
        self.assertRegex(shown.getvalue(), r"^200 steps, at last (1\.9\d|2\.0\d) N of 2; mean reward -0\.[0-2]")


if __name__ == "__main__":
    unittest.main()
