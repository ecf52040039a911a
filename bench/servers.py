"""Programs that bench/run.py asks for times, one after another."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

VENV = Path(__file__).resolve().parent.parent / "third_party" / "bench-peers"
# Rounds that are not counted: they warm up caches, allocators and just-in-time compilers.
WARM_UP = 2
# Seconds to wait for an answer; torch.compile's first takes longest.
PATIENCE = 600
# Largest difference between two programs' losses, as a fraction of the largest loss.
TOLERANCE = 1e-4
# The same for programs that compute in fewer bits.
ROUNDED = {"backward": 1e-3, "careful": 1e-2}


class Failure(Exception):
    """A part that cannot be measured, and why."""


class Server:
    """A program that answers one line with one line, bound to as many cores as it has threads."""

    def __init__(self, command, threads):
        own = sorted(os.sched_getaffinity(0))
        if len(own) < threads:
            raise Failure(f"{threads} threads: wanted as many cores, got {len(own)}")
        cores = ",".join(map(str, own[-threads:]))
        environ = {
            **os.environ,
            "OMP_NUM_THREADS": str(threads),
            "MKL_NUM_THREADS": str(threads),
            # What torch.compile builds is kept between runs. It is built without a pool of processes, because each
            # would take longer to import PyTorch than these few kernels take to compile.
            "TORCHINDUCTOR_CACHE_DIR": str(VENV / "compiled"),
            "TORCHINDUCTOR_COMPILE_THREADS": "1",
        }
        self.process = subprocess.Popen(
            ["taskset", "--cpu-list", cores, *map(str, command)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environ,
        )

    def ask(self, *question):
        self.process.stdin.write(" ".join(map(str, question)) + "\n")
        self.process.stdin.flush()
        watch = threading.Timer(PATIENCE, self.process.kill)
        watch.start()
        answer = self.process.stdout.readline()
        watch.cancel()
        if not answer:
            raise Failure(f"{' '.join(self.process.args)}: no answer within {PATIENCE} s to {question}; see --skip")
        return [float(word) for word in answer.split()]

    def peak(self):
        """Peak memory (MB)."""
        status = Path("/proc", str(self.process.pid), "status").read_text()
        return int(status.split("VmHWM:")[1].split()[0]) / 1024

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def interleave(servers, programs, count, rounds, what):
    """Rounds of (wall, CPU) milliseconds by program; `programs` gives the server of each."""
    times = {name: [] for name in programs}
    began = time.monotonic()
    for i in range(rounds + WARM_UP):
        for name, server in programs.items():
            progress(f"{what}: round {i + 1} of {rounds + WARM_UP}, {time.monotonic() - began:.0f} s, {name}")
            answer = servers[server].ask("time", name, count)
            if i >= WARM_UP:
                times[name].append(answer)
    progress(f"{what}: {time.monotonic() - began:.0f} s\n")
    return times


def check(servers, programs, updates):
    """Fails unless every program's losses over its first updates agree with copq's."""
    wanted = servers["copq"].ask("check", "copq", updates)
    scale = max(map(abs, wanted))  # One scale for all losses, since some pass through zero.
    for name, server in programs.items():
        progress(f"losses of {name}")
        losses = servers[server].ask("check", name, updates)
        worst = max(abs(a - b) for a, b in zip(losses, wanted, strict=True)) / scale
        progress(f"losses of {name:<9} differ from copq's by at most {worst:.1e} of the largest\n")
        if not worst < ROUNDED.get(name, TOLERANCE):
            raise Failure(f"{name} does not compute the same: {losses} and {wanted}")


def peaks(commands, programs, updates, threads):
    """Peak memory (MB) by program, each in a separate process."""
    peaks = {}
    for name, server in programs.items():
        progress(f"memory of {name}")
        alone = Server(commands[server], threads)
        alone.ask("time", name, updates)
        peaks[name] = alone.peak()
        alone.close()
    progress("")
    return peaks


def progress(text):
    """Overwrites the terminal's last line."""
    print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
