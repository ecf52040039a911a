"""Steps of Python environments through copq's bridge and in Python alone: wall time in interleaved rounds.

    scripts/python-worlds.sh
    cargo build --release -p copq-bench --bin bridge-steps
    third_party/gymnasium/bin/python bench/peers/bridge_steps.py target/release/bridge-steps
    third_party/safety-gymnasium/bin/python bench/peers/bridge_steps.py target/release/bridge-steps

Both sides play random actions. Resets are not timed.
"""

import importlib
import statistics
import subprocess
import sys
import time

import gymnasium
import numpy as np

TASKS = [
    "gymnasium:Pendulum-v1",
    "gymnasium:Hopper-v5",
    "gymnasium:Humanoid-v5",
    "mo-gymnasium:mo-hopper-v5",
    "safety-gymnasium:SafetyHopperVelocity-v1",
    "safety-gymnasium:SafetyPointGoal1-v0",
]
ROUNDS = 15
STEPS = 1000


def alone(env, actions):
    """Microseconds a step."""
    spent, ended = 0.0, True
    for step, action in enumerate(actions):
        if ended:
            env.reset(seed=step)
        began = time.perf_counter()
        *_, terminated, truncated, _ = env.step(action)
        spent += time.perf_counter() - began
        ended = terminated or truncated
    return 1e6 * spent / len(actions)


def bridged(server, task):
    server.stdin.write(f"{task} {sys.executable} {STEPS}\n")
    server.stdin.flush()
    return float(server.stdout.readline())


def text(values):
    return f"{statistics.median(values):.0f} ({min(values):.0f} to {max(values):.0f})"


def main():
    server = subprocess.Popen([sys.argv[1]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    print(f"us a step, median (smallest to largest) of {ROUNDS} interleaved rounds of {STEPS} steps\n")
    print("| environment | Python alone | through the bridge | what the bridge costs |\n|---|--:|--:|--:|")
    for task in TASKS:
        package, name = task.split(":")
        try:
            env = importlib.import_module(package.replace("-", "_")).make(name)
        except (ModuleNotFoundError, gymnasium.error.Error):
            continue  # It needs another interpreter.
        space, rng = env.action_space, np.random.default_rng(1)
        actions = [rng.uniform(space.low, space.high).astype(space.dtype) for _ in range(STEPS)]
        alone(env, actions[:100]), bridged(server, task)
        rounds = [(alone(env, actions), bridged(server, task)) for _ in range(ROUNDS)]
        own, through = zip(*rounds)
        print(f"| {task} | {text(own)} | {text(through)} | {text([b - a for a, b in rounds])} |", flush=True)


if __name__ == "__main__":
    main()
