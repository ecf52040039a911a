"""Environments that misbehave in one way each, from step 5 on or from the start."""

import atexit
import ctypes
import os
import random
import subprocess
import sys
import threading
import time

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete

NUMBER = Box(-np.inf, np.inf, (2,))


class Faulty(gymnasium.Env):
    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, fault="none", render_mode=None, number=0.0, file=None):
        self.render_mode = render_mode
        self.fault = fault
        self.steps = 0
        self.action_space = Box(-1, 1, (1,))
        self.observation_space = NUMBER
        if fault == "discrete":
            self.action_space = Discrete(3)
        if fault == "unbounded":
            self.action_space = Box(-np.inf, np.inf, (1,))
        if fault == "dictionary":
            self.observation_space = Dict({"a": NUMBER})
        if fault == "enormous":
            self.observation_space = Box(0, 255, (4096, 4096, 3), np.uint8)
        if fault == "chance":
            self.drawn = random.random() + np.random.random()
        if fault == "start":
            raise RuntimeError("no licence")
        if fault == "slow start":
            time.sleep(1000)
        if fault == "told":
            raise RuntimeError(f"{number!r} and {sys.argv[1:]}")
        if file is not None:
            open(file, "w").close()
            atexit.register(os.remove, file)

    def reset(self, seed=None, options=None):
        super().reset(seed=seed)
        self.steps = 0
        if self.fault == "sampled":
            return self.observation_space.sample(), {}
        return np.zeros(2), {}

    def step(self, action):
        self.steps += 1
        obs, reward = np.array([self.steps, action[0]]), 1.0
        if self.steps >= 5:
            obs, reward = self.misbehave(obs, reward)
        return obs, reward, self.fault == "both" and self.steps >= 5, self.steps >= 10, {}

    def misbehave(self, obs, reward):
        match self.fault:
            case "raise":
                raise ValueError("the gripper is stuck")
            case "cause":
                try:
                    raise KeyError("joint 3")
                except KeyError as error:
                    raise ValueError("no such joint") from error
            case "cause of itself":
                try:
                    raise KeyError("joint 3")
                except KeyError as error:
                    raise error from error
            case "note":
                error = ValueError("the gripper is stuck")
                error.add_note("in scene 4")
                raise error
            case "exit":
                sys.exit(3)
            case "print":
                print("a line on standard output", flush=True)
                os.write(1, b"and one past Python's own\n")
                os.write(1, b"x" * 200_000)
            case "hang":
                time.sleep(1000)
            case "hang for ever":
                # Holds the interpreter's lock, as broken extensions do.
                ctypes.PyDLL(None).sleep(1000)
            case "child":
                subprocess.Popen(["sleep", "1000"])
                time.sleep(1000)
            case "segfault":
                ctypes.string_at(0)
            case "kill":
                os.kill(os.getpid(), 9)
            case "nan":
                reward = float("nan")
            case "infinite":
                obs = obs * 1e300
            case "length":
                obs = np.zeros(3)
            case "huge":
                obs = np.zeros(50_000_000)
            case "vector":
                reward = [1.0, 2.0]
            case "nothing":
                reward = None
            case "odd words":
                raise ValueError("\udcff")
            case "many words":
                raise ValueError("far too " * 10_000_000)
            case "wait":
                os.waitpid(-1, 0)
            case "fork":
                child = os.fork()
                if not child:
                    raise RuntimeError("a child that comes back")
                os.waitpid(child, 0)
            case "thread":
                threading.Thread(target=time.sleep, args=(1000,)).start()
                self.fault = "none"
            case "chance":
                reward = random.random() + np.random.random() + self.drawn
        return obs, reward

    def render(self):
        return np.full((30, 50, 3), self.steps, np.uint8)


class Once(Faulty):
    """Misbehaves in the first episode alone."""

    def reset(self, seed=None, options=None):
        if self.steps:
            self.fault = "none"
        return super().reset(seed=seed)


class Bounded(gymnasium.ActionWrapper):
    """What is advised for actions without bounds."""

    def __init__(self, env):
        super().__init__(env)
        self.action_space = Box(-1, 1, env.action_space.shape)

    def action(self, action):
        return 10 * action


class Parts(gymnasium.Wrapper):
    """A reward told in two numbers, and how many there are."""

    def __init__(self, env):
        super().__init__(env)
        self.reward_space = Box(-np.inf, np.inf, (2,))

    def step(self, action):
        obs, reward, *rest = self.env.step(action)
        return obs, np.array([reward, -reward]), *rest


class LinearReward(gymnasium.Wrapper):
    """One number of several again, as MO-Gymnasium's wrapper of this name."""

    def step(self, action):
        obs, reward, *rest = self.env.step(action)
        return obs, float(reward.sum()), *rest


def advised():
    return Bounded(Faulty("unbounded"))


def parts():
    return Parts(Faulty())


def added():
    return LinearReward(parts())


gymnasium.register("copq/Advised-v0", advised, max_episode_steps=10)
gymnasium.register("copq/Parts-v0", parts, max_episode_steps=10)
gymnasium.register("copq/Added-v0", added, max_episode_steps=10)
gymnasium.register("copq/Faulty-v0", Faulty, max_episode_steps=10)
gymnasium.register("copq/Once-v0", Once, max_episode_steps=10)
gymnasium.register("copq/Endless-v0", Faulty)
