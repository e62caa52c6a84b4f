"""Learn to press with a wanted force: an environment of gymnasium, each of whose actions moves a hand.

    from gym_env import PressEnv
    env = PressEnv(palpate.load("cube"), force=2.0)
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

Needs gymnasium (pip install gymnasium), whose environments learning libraries take.  Run as a program, it lets a simple
rule press in a scene, and prints how well it did.
"""

import sys

import gymnasium
import numpy

import palpate


class PressEnv(gymnasium.Env):
    """A hand that comes from above is to press an object with a force, and to hold it.

    action       how far the hand moves along x, y and z in this step, in parts of 1 mm
    observation  the force in N, the tool's distance from the hand in mm, the hand's place from the start in mm
    reward       minus the distance from the wanted force, upwards, in N

    A step of the environment is `frames` milliseconds, in which the hand moves evenly.  The same seed and actions give
    the same bits.  It ends after `steps` of them, and before that with more than ten times the force.
    """

    metadata = {"render_modes": []}
    render_mode = None

    def __init__(self, scene, *, tool=0, start=(0.0, 0.032, 0.0), force=2.0, frames=10, steps=200):
        self.model = scene.model(tool)
        self.start, self.force, self.frames, self.steps = numpy.array(start), force, frames, steps
        self.proxy, self.hand, self.taken = palpate.Proxy(self.model, self.start), self.start, 0
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), dtype=numpy.float32)
        self.observation_space = gymnasium.spaces.Box(-numpy.inf, numpy.inf, (9,), dtype=numpy.float32)

    def _observe(self, wrench, tool):
        return numpy.concatenate([wrench[:3], 1e3 * (tool[:3] - self.hand), 1e3 * (self.hand - self.start)]).astype(
            numpy.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.hand = self.start + self.np_random.uniform(-0.001, 0.001, 3)
        self.taken = 0
        self.proxy.restart(self.hand)
        felt = self.proxy.step(self.hand)
        return self._observe(felt.force, felt.pose), {}

    def step(self, action):
        if numpy.shape(action) != (3,) or not numpy.isfinite(action).all():
            raise ValueError(f"action: must be three finite numbers, is {action}")
        before = self.hand
        self.hand = before + 1e-3 * numpy.clip(numpy.asarray(action, float), -1, 1)
        felt = self.proxy.steps(numpy.linspace(before, self.hand, self.frames + 1)[1:])
        self.taken += 1
        force = felt.wrench[-1, :3]
        terminated = bool(numpy.linalg.norm(force) > 10 * self.force)
        reward = -float(numpy.linalg.norm(force - [0, self.force, 0]))
        info = {"faults": palpate.fault_words(int(numpy.bitwise_or.reduce(felt.faults)))}
        return self._observe(felt.wrench[-1], felt.pose[-1]), reward, terminated, self.taken >= self.steps, info


def main():
    env = PressEnv(palpate.load(sys.argv[1] if len(sys.argv) > 1 else "cube"))
    observation, _ = env.reset(seed=1)
    rewards, done = [], False
    while not done:
        missing = env.force - observation[1]  # N, at 1 N for each mm
        observation, reward, terminated, truncated, _ = env.step(numpy.array([0, -0.2 * missing, 0]))
        rewards.append(reward)
        done = terminated or truncated
    print(f"{len(rewards)} steps, at last {observation[1]:.2f} N of {env.force:g}; "
          f"mean reward {numpy.mean(rewards):.2f}")


if __name__ == "__main__":
    main()
