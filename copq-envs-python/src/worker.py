"""An environment of Python's for copq, which runs this file with the environment's own interpreter.

Standard input is a socket, both ways. First goes one line of JSON that says what the environment is, or what is wrong.
Then every request has its answer, numbers little-endian:

    b"r" seed (u64)          -> status, observation (f32 each)
    b"s" action (f32 each)   -> status, observation (f32 each), reward (f32 each)
    b"p"                     -> status, height and width (u32 each), red, green and blue of every pixel (u8 each)

The status is one byte: 0 running, 1 terminated, 2 truncated; or 255, and then comes a text with its length (u32)
instead. Whatever anybody prints goes to standard error.
"""

import faulthandler
import importlib
import json
import os
import resource
import select
import signal
import socket
import struct
import sys
import time
import traceback

PACKAGES = {"gymnasium": "gymnasium", "mo-gymnasium": "mo_gymnasium", "safety-gymnasium": "safety_gymnasium"}
# What its numbers depend on.
VERSIONS = ["gymnasium", "mo_gymnasium", "safety_gymnasium", "mujoco", "numpy"]
RUNNING, TERMINATED, TRUNCATED, FAILED = 0, 1, 2, 255
LONGEST_OBSERVATION = 1 << 20
# Seconds that a worker may take to close its environment when nobody listens any more.
GRACE = 5


class Refused(Exception):
    """An environment that copq cannot use: what was wanted, and what it is."""


def guard(connection):
    """Kills this group of processes when the other side of the connection is gone, however busy the worker is."""
    worker = os.getpid()
    if os.fork():
        return
    ends = select.poll()
    ends.register(connection, 0)
    while os.getppid() == worker and not ends.poll(500):
        pass
    deadline = time.monotonic() + GRACE
    while os.getppid() == worker and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(0, signal.SIGKILL)


def make(settings):
    """The environment that the settings name."""
    name = PACKAGES[settings["package"]]
    if settings["render"] and not {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
        # MuJoCo's pictures without a screen.
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        package = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise Refused(f"wanted the package {name} in {sys.executable}, got none (pip install {settings['package']})")
    for module in settings["imports"]:
        if module.endswith(".py"):
            folder, module = os.path.split(os.path.abspath(module))
            sys.path.insert(0, folder)
            module = module[: -len(".py")]
        importlib.import_module(module)
    arguments = dict(settings["kwargs"])
    if settings["render"]:
        arguments["render_mode"] = "rgb_array"
    # Its checks are for authors; they do not know vectors of rewards.
    return package.make(settings["id"], **{"disable_env_checker": True, **arguments})


def box(space, of, wanted, advice):
    """A space of numbers, or what would help."""
    if type(space).__name__ != "Box" or space.dtype.kind not in wanted:
        raise Refused(f"{of}: wanted a Box of numbers, got {space}; {advice}")
    return space


class World:
    """An environment, and its spaces as flat arrays."""

    def __init__(self, settings):
        import numpy

        self.numpy = numpy
        self.package = settings["package"]
        self.env = make(settings)
        self.actions = box(
            self.env.action_space, "actions", "f",
            "a wrapper of your own (gymnasium.ActionWrapper) can take them from numbers",
        )
        self.observations = box(
            self.env.observation_space, "observations", "fiub",
            "gymnasium.wrappers.FlattenObservation can make it one",
        )
        self.obs_len = int(numpy.prod(self.observations.shape, dtype=int))
        if self.obs_len > LONGEST_OBSERVATION:
            raise Refused(f"observations: wanted at most {LONGEST_OBSERVATION} numbers, got {self.observations.shape}")
        self.rewards = self.count_rewards()

    def count_rewards(self):
        """How many numbers a reward has; None if it is one and not a vector."""
        space = getattr(self.env.unwrapped, "reward_space", None)
        if self.package == "mo-gymnasium" and space is None:
            raise Refused("rewards: wanted an environment that says how many it has (reward_space), got none")
        return None if space is None else int(self.numpy.prod(space.shape, dtype=int))

    def describe(self):
        """What copq has to know before the first episode."""
        spec, low, high = self.env.spec, self.actions.low, self.actions.high
        if not (self.numpy.isfinite(low).all() and self.numpy.isfinite(high).all()):
            raise Refused(
                f"actions: wanted finite bounds, got {self.actions}; gymnasium.wrappers.RescaleAction can set some"
            )
        horizon = getattr(spec, "max_episode_steps", None)
        if horizon is None:
            raise Refused(
                "length of episodes: wanted a limit, got none (max_episode_steps where it is registered, or among "
                "the arguments that it is made with)"
            )
        modules = [(name, sys.modules.get(name)) for name in VERSIONS]
        versions = [f"{name} {module.__version__}" for name, module in modules if hasattr(module, "__version__")]
        return {
            "obs_len": self.obs_len,
            "action_low": low.astype(float).ravel().tolist(),
            "action_high": high.astype(float).ravel().tolist(),
            "rewards": self.rewards,
            "has_cost": self.package == "safety-gymnasium",
            "horizon": horizon,
            "frames_per_second": self.env.metadata.get("render_fps") or 30,
            "versions": ", ".join([f"Python {sys.version.split()[0]}", *versions]),
        }

    def reset(self, seed):
        """Begins an episode."""
        return bytes([RUNNING]) + self.seen(self.env.reset(seed=seed)[0])

    def step(self, action):
        """One step; the cost comes before the reward."""
        action = self.numpy.frombuffer(action, "<f4").astype(self.actions.dtype).reshape(self.actions.shape)
        if action.dtype.itemsize != 4:
            # Its bounds were rounded on their way.
            action = action.clip(self.actions.low, self.actions.high)
        obs, reward, *cost, terminated, truncated, _ = self.env.step(action)
        status = TERMINATED if terminated else TRUNCATED if truncated else RUNNING
        wanted = 1 if self.rewards is None else self.rewards
        return bytes([status]) + self.seen(obs) + self.numbers([*cost, reward] if cost else reward, len(cost) + wanted)

    def seen(self, obs):
        return self.numbers(obs, self.obs_len, "observation")

    def numbers(self, values, wanted, of="reward"):
        """So many numbers as bytes."""
        array = self.numpy.asarray(values)
        if array.size != wanted:
            raise ValueError(f"{of}: wanted {wanted} numbers, got {array.size} (shape {array.shape})")
        return array.astype("<f4").tobytes()

    def picture(self):
        """What the environment looks like now."""
        frame = self.numpy.asarray(self.env.render())
        if frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != self.numpy.uint8:
            raise ValueError(f"picture: wanted rows of red, green and blue bytes, got {frame.dtype} {frame.shape}")
        return struct.pack("<BII", RUNNING, *frame.shape[:2]) + frame.tobytes()


def last_lines(error):
    """What was raised, and where: the frames of others than this program, which python is given as a text."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename not in ("<copq>", "<string>")]
    said = traceback.format_exception_only(type(error), error)[-1].strip()
    return said + "".join(f"\n  {frame.filename}:{frame.lineno} in {frame.name}: {frame.line}" for frame in frames[-5:])


def failure(error):
    text = last_lines(error).encode()
    return struct.pack("<BI", FAILED, len(text)) + text


def serve(world, requests, connection):
    """Answers until nobody asks any more."""
    while command := requests.read(1):
        try:
            if command == b"s":
                answer = world.step(requests.read(4 * world.actions.low.size))
            elif command == b"r":
                answer = world.reset(*struct.unpack("<Q", requests.read(8)))
            else:
                answer = world.picture()
        except BaseException as error:
            answer = failure(error)
        connection.sendall(answer)
    world.env.close()


def main():
    connection = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    guard(connection)
    # Where a crash was, in words and not in a core file.
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # The current folder, for modules of the user's.
    sys.path.insert(0, "")
    try:
        world = World(json.loads(sys.argv[1]))
        hello = world.describe()
    except BaseException as error:
        hello = {"error": str(error) if isinstance(error, Refused) else last_lines(error)}
    connection.sendall(json.dumps(hello).encode() + b"\n")
    if "error" not in hello:
        serve(world, connection.makefile("rb"), connection)


main()
