"""A Python environment for copq, which runs this file with the environment's own interpreter.

Standard input is a socket, used both ways. First this program sends a text (JSON, preceded by its length as u32) that
describes the environment, or says what is wrong. Then it answers every request; numbers are little-endian:

    b"r" seed (u64)          -> status, observation (f32 each)
    b"s" action (f32 each)   -> status, observation (f32 each), reward (f32 each)
    b"p"                     -> status, height and width (u32 each), red, green and blue of every pixel (u8 each)

The status is one byte: 0 running, 1 terminated, 2 truncated; or 255, and then a text follows instead. Anything that is
printed goes to standard error.
"""

import atexit
import faulthandler
import importlib
import importlib.util
import json
import os
import random
import resource
import select
import signal
import socket
import struct
import sys
import time
import traceback

PACKAGES = {"gymnasium": "gymnasium", "mo-gymnasium": "mo_gymnasium", "safety-gymnasium": "safety_gymnasium"}
# Packages that the environment's numbers depend on.
VERSIONS = ["gymnasium", "mo_gymnasium", "safety_gymnasium", "mujoco", "numpy"]
RUNNING, TERMINATED, TRUNCATED, FAILED = 0, 1, 2, 255
LONGEST_OBSERVATION = 1 << 20
# Characters of an error that are passed on.
LONGEST_ERROR = 20_000
# Seconds that a worker may take to close its environment when nobody listens any more.
GRACE = 5


class Refused(Exception):
    """An environment that copq cannot use: what was wanted, and what it is."""


def guard(connection):
    """Starts a process that kills this process group when the other side of the connection is gone, however busy the
    worker is. It is not the worker's child, because environments may wait for their children. What an environment has
    started in its own session is not in the group: it ends when the environment closes it.
    """
    worker = os.getpid()
    middle = os.fork()
    if middle:
        os.waitpid(middle, 0)
        return
    if os.fork():
        os._exit(0)
    for number in signal.SIGHUP, signal.SIGINT, signal.SIGTERM:
        signal.signal(number, signal.SIG_IGN)
    end = select.poll()
    end.register(connection, 0)
    end.poll()
    deadline = time.monotonic() + GRACE
    while time.monotonic() < deadline and is_there(worker):
        time.sleep(0.05)
    os.killpg(0, signal.SIGKILL)


def is_there(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def imported(number, module):
    """Imports a module by its name or by its file."""
    if not module.endswith(".py"):
        importlib.import_module(module)
        return
    path = os.path.abspath(module)
    if not os.path.isfile(path):
        raise Refused(f"module to import: wanted a file, got none at {path}")
    folder, name = os.path.split(path)
    name = name[: -len(".py")]
    # Modules beside it can be imported, but do not hide other modules.
    sys.path.append(folder)
    if name in sys.modules:
        name = f"{name}_{number}"
    spec = importlib.util.spec_from_file_location(name, path)
    sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[name])


def seed(number):
    """Seeds Python's and NumPy's own generators."""
    import numpy

    random.seed(number)
    numpy.random.seed(number)


def make(settings):
    """The environment that the settings name."""
    name = PACKAGES[settings["package"]]
    has_screen = {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()
    if settings["render"] and sys.platform == "linux" and not has_screen:
        # So that MuJoCo draws without a screen.
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        package = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise Refused(
            f"wanted an interpreter with the package {name}, got {sys.executable} without it (pip install "
            f"{settings['package']} there, or name another interpreter with --python PATH)"
        )
    # An environment that is built at random is the same one in every process.
    seed(0)
    for number, module in enumerate(settings["imports"]):
        imported(number, module)
    arguments = dict(settings["kwargs"])
    if not settings["render"]:
        # The checks are for authors of environments, and do not know vectors of rewards.
        return package.make(settings["id"], **{"disable_env_checker": True, **arguments})
    try:
        env = package.make(settings["id"], **{"disable_env_checker": True, **arguments, "render_mode": "rgb_array"})
    except TypeError as error:
        if "render_mode" not in str(error):
            raise
        raise Refused(f"wanted an environment that draws itself (render_mode='rgb_array'), got one that says: {error}")
    if "rgb_array" not in env.metadata.get("render_modes", []):
        env.close()
        raise Refused(f"wanted an environment that draws itself (rgb_array among its render_modes), got {env.metadata}")
    return env


def box(space, of, kinds, wanted, advice):
    """Returns a space of numbers; for any other, raises what would help."""
    if type(space).__name__ != "Box" or space.dtype.kind not in kinds:
        raise Refused(f"{of}: wanted a Box of {wanted}, got {space}; {advice}")
    return space


class World:
    """An environment, and its spaces as flat arrays."""

    def __init__(self, env, settings):
        self.env = env
        import numpy

        self.numpy = numpy
        self.package = settings["package"]
        self.costs = 1 if self.package == "safety-gymnasium" else 0
        self.process = os.getpid()
        self.actions = box(
            self.env.action_space, "actions", "f", "floats",
            "wrap it in a gymnasium.ActionWrapper that takes floats, register that, and --import the module",
        )
        self.observations = box(
            self.env.observation_space, "observations", "fiub", "numbers",
            "wrap it, perhaps in gymnasium.wrappers.FlattenObservation, register that, and --import the module",
        )
        self.obs_len = int(numpy.prod(self.observations.shape, dtype=int))
        if self.obs_len > LONGEST_OBSERVATION:
            raise Refused(f"observations: wanted at most {LONGEST_OBSERVATION} numbers, got {self.observations.shape}")
        self.layers = self.unwrapped()
        self.rewards = self.count_rewards()

    def unwrapped(self):
        """The environment and, within each wrapper, what it wraps."""
        from gymnasium import Wrapper

        layers = [self.env]
        while isinstance(layers[-1], Wrapper):
            layers.append(layers[-1].env)
        return layers

    def count_rewards(self):
        """How many numbers a reward has, by the outermost wrapper that says so; None if it is a single number."""
        from gymnasium import Wrapper

        env = self.env
        # Some wrappers pass on attributes that they do not have themselves.
        while isinstance(env, Wrapper) and not ("reward_space" in vars(env) or hasattr(type(env), "reward_space")):
            if type(env).__name__ == "LinearReward":
                # MO-Gymnasium's wrapper, which adds the rewards up.
                return None
            env = env.env
        space = getattr(env, "reward_space", None)
        if self.package == "mo-gymnasium" and space is None:
            raise Refused("rewards: wanted an environment that says how many it has (reward_space), got none")
        return None if space is None else int(self.numpy.prod(space.shape, dtype=int))

    def describe(self):
        """What copq has to know before the first episode."""
        low, high = (bound.astype("f4").ravel() for bound in (self.actions.low, self.actions.high))
        if not (self.numpy.isfinite(low).all() and self.numpy.isfinite(high).all()):
            raise Refused(
                f"actions: wanted finite bounds that fit 32 bits, got {self.actions}; wrap it in a gymnasium."
                "ActionWrapper with an action_space of Box(-1, 1, ...), register that, and --import the module"
            )
        horizon = getattr(self.env.spec, "max_episode_steps", None)
        if horizon is None or horizon < 1:
            raise Refused(
                "length of episodes: wanted a limit, got none (set max_episode_steps where it is registered, "
                """or with --env-kwargs '{"max_episode_steps": 1000}')"""
            )
        modules = [(name, sys.modules.get(name)) for name in VERSIONS]
        versions = [f"{name} {module.__version__}" for name, module in modules if hasattr(module, "__version__")]
        return {
            "obs_len": self.obs_len,
            "action_low": low.tolist(),
            "action_high": high.tolist(),
            "rewards": self.rewards,
            "has_cost": self.costs > 0,
            "horizon": int(horizon),
            "frames_per_second": self.frames_per_second(),
            "versions": ", ".join([f"Python {sys.version.split()[0]}", *versions]),
        }

    def frames_per_second(self):
        try:
            wanted = float(self.env.metadata["render_fps"])
        except (KeyError, TypeError, ValueError):
            return 30.0
        return wanted if 0 < wanted < float("inf") else 30.0

    def reset(self, number):
        """Begins an episode. Randomness that an environment takes from Python's or NumPy's own generators, or from
        its spaces, is seeded as well.
        """
        seed(number)
        for env in self.layers:
            for name in "action_space", "observation_space":
                if space := getattr(env, name, None):
                    space.seed(number)
        return bytes([RUNNING]) + self.seen(self.env.reset(seed=number)[0])

    def step(self, action):
        """One step; the cost comes before the reward."""
        action = self.numpy.frombuffer(action, "<f4").astype(self.actions.dtype).reshape(self.actions.shape)
        if action.dtype.itemsize != 4:
            # The bounds were rounded on their way to copq.
            action = action.clip(self.actions.low, self.actions.high)
        obs, reward, *cost, terminated, truncated, _ = self.env.step(action)
        if len(cost) != self.costs:
            raise ValueError(f"step: wanted {5 + self.costs} values, got {5 + len(cost)}")
        status = TERMINATED if terminated else TRUNCATED if truncated else RUNNING
        values = self.numbers(reward, 1 if self.rewards is None else self.rewards, "reward")
        for number in cost:
            values = self.numbers(number, 1, "cost") + values
        return bytes([status]) + self.seen(obs) + values

    def seen(self, obs):
        return self.numbers(obs, self.obs_len, "observation")

    def numbers(self, values, wanted, of):
        """The numbers as bytes; there must be as many as wanted."""
        array = self.numpy.asarray(values)
        if array.dtype.kind not in "fiub":
            raise ValueError(f"{of}: wanted numbers, got {values!r:.200}")
        if array.size != wanted:
            advice = "; set the environment's reward_space for a vector of rewards" if of == "reward" else ""
            raise ValueError(f"{of}: wanted {wanted} numbers, got {array.size} (shape {array.shape}){advice}")
        # A number that does not fit becomes infinite, which copq reports.
        return array.astype("<f4").tobytes()

    def picture(self):
        """What the environment looks like now."""
        frame = self.numpy.asarray(self.env.render())
        if frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != self.numpy.uint8:
            raise ValueError(f"picture: wanted rows of red, green and blue bytes, got {frame.dtype} {frame.shape}")
        return struct.pack("<BII", RUNNING, *frame.shape[:2]) + frame.tobytes()

    def serve(self, requests, connection):
        """Answers requests until there are no more."""
        while command := requests.read(1):
            try:
                if command == b"s":
                    answer = self.step(requests.read(4 * self.actions.low.size))
                elif command == b"r":
                    answer = self.reset(*struct.unpack("<Q", requests.read(8)))
                else:
                    answer = self.picture()
            except BaseException as error:
                answer = bytes([FAILED]) + text(last_lines(error)[:LONGEST_ERROR])
            if os.getpid() != self.process:
                # A child that the environment has forked, and that has returned to here.
                os._exit(1)
            connection.sendall(answer)


def last_lines(error, known=()):
    """What was raised, and where: the frames outside this program, which Python is given as a text; then the error that
    it came after, unless that one is known.
    """
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename != "<copq>"]
    said = "".join(traceback.format_exception_only(type(error), error)).strip()
    said += "".join(f"\n  {frame.filename}:{frame.lineno} in {frame.name}: {frame.line}" for frame in frames[-5:])
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    known = [*known, error]
    if cause is None or any(cause is other for other in known):
        return said
    return f"{said}\nafter {last_lines(cause, known)}"


def text(words):
    """A text preceded by its length."""
    coded = words.encode(errors="backslashreplace")
    return struct.pack("<I", len(coded)) + coded


def main():
    connection = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    guard(connection)
    # Says where a crash was in words, not in a core file.
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # The environment's modules do not see copq's argument on the command line.
    settings = json.loads(sys.argv.pop(1))
    env = world = None
    try:
        env = make(settings)
        world = World(env, settings)
        hello = world.describe()
    except BaseException as error:
        said = (str(error) if isinstance(error, Refused) else last_lines(error))[:LONGEST_ERROR]
        hello = {"error": said.encode(errors="backslashreplace").decode()}
    try:
        connection.sendall(text(json.dumps(hello)))
        if "error" not in hello:
            world.serve(connection.makefile("rb"), connection)
    except OSError:
        # The other side is gone.
        pass
    leave(env)


def leave(env):
    """Ends as Python does, except that threads which the environment has left do not delay it."""
    ends = [atexit._run_exitfuncs] if env is None else [env.close, atexit._run_exitfuncs]
    for end in ends:
        try:
            end()
        except BaseException:
            traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


main()
