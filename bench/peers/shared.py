"""What the peers share: the benchmark's weights and batches, and the answers that bench/run.py asks for."""

import re
import sys
import time
from pathlib import Path

from safetensors.numpy import load_file

DISCOUNT = 0.99
TAU = 0.005
LR = 3e-4


class Workload:
    """What `update --write FOLDER` wrote, as numpy arrays."""

    def __init__(self, folder, actor_delay):
        self.actor_delay = actor_delay
        networks = load_file(Path(folder, "networks.safetensors"))
        batches = load_file(Path(folder, "batches.safetensors"))
        number = lambda names: 1 + max(int(re.match(r"\d+", name)[0]) for name in names)
        first = "critics/critic."
        count = number(name.removeprefix(first) for name in networks if name.startswith(first))
        self.critics = [network(networks, f"{first}{k}/online") for k in range(count)]
        self.actor = network(networks, "actor/online")
        self.batches = [
            {name.split(".")[1]: array for name, array in batches.items() if name.startswith(f"{i}.")}
            for i in range(number(batches))
        ]


def network(arrays, prefix):
    """(weight, bias) of each layer; weights are output x input."""
    layers = sum(name.startswith(f"{prefix}/") for name in arrays) // 2
    return [(arrays[f"{prefix}/layer.{i}.weight"], arrays[f"{prefix}/layer.{i}.bias"]) for i in range(layers)]


def serve(programs):
    """Answers `check NAME UPDATES` with the losses of a fresh start, and `time NAME UPDATES` with the milliseconds of
    an update, as wall time and as CPU time.

    `programs[NAME]()` makes a program. Its `run(updates)` does that many more updates and returns their losses: each
    update's critic losses, then the actor's if it moved. `flat(losses)` turns them into plain numbers.
    """
    running = {}
    for line in sys.stdin:
        question, name, updates = line.split()
        if question == "check":
            program = programs[name]()
            print(*program.flat(program.run(int(updates))), flush=True)
        else:
            if name not in running:
                running[name] = programs[name]()
            program = running[name]
            wall, cpu = time.perf_counter_ns(), time.process_time_ns()
            program.wait(program.run(int(updates)))
            scale = 1e-6 / int(updates)
            wall, cpu = time.perf_counter_ns() - wall, time.process_time_ns() - cpu
            print(wall * scale, cpu * scale, flush=True)
