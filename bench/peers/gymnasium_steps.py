"""Gymnasium's env.step against ours on the same MuJoCo, in CPU time of the stepping thread, in interleaved rounds.

    python3 -m venv /tmp/gym && /tmp/gym/bin/pip install gymnasium==1.4.0 mujoco==3.17.0
    cargo build --release -p copq-bench --features mujoco
    /tmp/gym/bin/python bench/peers/gymnasium_steps.py target/release/mujoco-steps

Both sides play random actions drawn beforehand, with reward, full observation and termination. Resets are not timed.
"""

import statistics
import subprocess
import sys
import time

import gymnasium
import mujoco
import numpy as np

ROBOTS = {
    "hopper": "Hopper-v5",
    "walker2d": "Walker2d-v5",
    "halfcheetah": "HalfCheetah-v5",
    "ant": "Ant-v5",
    "humanoid": "Humanoid-v5",
}
ROUNDS = 15
STEPS = 2000


def gymnasium_step(env, actions):
    """Nanoseconds a step."""
    spent, left = 0, iter(actions)
    action = next(left, None)
    seed = 0
    while action is not None:
        env.reset(seed=seed)
        seed += 1
        start = time.thread_time_ns()
        ended = False
        while not ended and action is not None:
            _, _, terminated, truncated, _ = env.step(action)
            ended = terminated or truncated
            action = next(left, None)
        spent += time.thread_time_ns() - start
    return spent / len(actions)


def ours(server, robot):
    server.stdin.write(f"env {robot} {STEPS}\n")
    server.stdin.flush()
    return float(server.stdout.readline())


def text(values):
    return f"{statistics.median(values) / 1e3:.2f} ({min(values) / 1e3:.2f}-{max(values) / 1e3:.2f})"


def main():
    server = subprocess.Popen([sys.argv[1], "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    print(f"Gymnasium {gymnasium.__version__}, MuJoCo {mujoco.__version__}, Python {sys.version.split()[0]}")
    print(f"us a step, median (smallest-largest) of {ROUNDS} interleaved rounds of {STEPS} steps; ratios by round")
    for robot, name in ROBOTS.items():
        env = gymnasium.make(name)
        rng = np.random.default_rng(1)
        space = env.action_space
        actions = [rng.uniform(space.low, space.high).astype(np.float32) for _ in range(STEPS)]
        gymnasium_step(env, actions[:200])
        rounds = [(gymnasium_step(env, actions), ours(server, robot)) for _ in range(ROUNDS)]
        theirs, own = zip(*rounds)
        ratios = [a / b for a, b in rounds]
        print(
            f"{robot:<12} gymnasium {text(theirs)}  copq {text(own)}  "
            f"ratio {statistics.median(ratios):.2f} ({min(ratios):.2f}-{max(ratios):.2f})",
            flush=True,
        )


if __name__ == "__main__":
    main()
