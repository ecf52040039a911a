#!/usr/bin/env python3
"""Times copq's update against its peers', interleaved, from the same weights and on the same batches.

    python3 bench/run.py                          everything, about an hour
    python3 bench/run.py --rounds 5 walker2d      one workload, roughly

It makes a private environment for the peers in third_party/bench-peers (git-ignored; the first time it downloads
several gigabytes, for PyPI's PyTorch brings CUDA along), builds copq, checks that all programs report the same losses,
times them in turns, and writes tables, a chart and raw times to bench/results. Needs Linux, Rust, a C compiler, python3
with venv, crates.io and PyPI.
"""

import argparse
import csv
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BENCH = Path(__file__).resolve().parent
ROOT = BENCH.parent
VENV = ROOT / "third_party" / "bench-peers"
RESULTS = BENCH / "results"
# A multiple of every workload's actor delay, and the number of batches.
UPDATES = 20
WORKLOADS = {"walker2d": 2, "humanoid": 2, "redq": 20}  # and their actor delays
PROGRAMS = {
    "products": ("copq", "its matrix products alone (`gemm`)"),
    "copq": ("copq", "**copq**"),
    "learner": ("copq", "copq's whole learner: replay, FAMO, reports"),
    "scan": ("jax", "JAX jit, scan over updates"),
    "step": ("jax", "JAX jit, one update a call"),
    "compiled": ("torch", "PyTorch, `torch.compile`"),
    "eager": ("torch", "PyTorch eager"),
    "autograd": ("copq", "candle autograd"),
    "plain": ("copq", "copq's plain candle networks"),
}
# Environment steps in a round of whole training.
STEPS = 400
TRAININGS = {
    "td3": ("copq", "copq, TD3 as Stable-Baselines3's"),
    "cop": ("copq", "copq, TD3-COP as its preset has it"),
    "sbx": ("peers", "SBX TD3 (JAX)"),
    "sb3": ("peers", "Stable-Baselines3 TD3 (PyTorch)"),
}
# What reports losses, all of which must agree.
CHECKED = ["copq", "plain", "autograd", "eager", "compiled", "step", "scan"]
TOLERANCE = 1e-4


def environment():
    """The peers' interpreter, freshly installed if it is not there or its list of packages has changed."""
    wanted, installed = BENCH / "peers" / "requirements.txt", VENV / "installed.txt"
    if not installed.exists() or installed.read_text() != wanted.read_text():
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([VENV / "bin" / "pip", "install", "--quiet", "--requirement", wanted], check=True)
        installed.write_text(wanted.read_text())
    return VENV / "bin" / "python"


def build(mujoco):
    """The folder of our programs."""
    if mujoco:
        subprocess.run([ROOT / "scripts" / "fetch-mujoco.sh"], check=True)
    features = ["--features", "mujoco"] if mujoco else []
    subprocess.run(["cargo", "build", "--release", "--locked", "-p", "copq-bench", *features], cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"), "release")


class Server:
    """A program that answers one line with one line."""

    def __init__(self, command, threads):
        cores = sorted(os.sched_getaffinity(0))[-threads:]
        environ = {**os.environ, "OMP_NUM_THREADS": str(threads), "MKL_NUM_THREADS": str(threads)}
        self.process = subprocess.Popen(
            list(map(str, command)),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environ,
            preexec_fn=lambda: os.sched_setaffinity(0, cores),
        )

    def ask(self, *question):
        self.process.stdin.write(" ".join(map(str, question)) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit(f"{self.process.args}: no answer to {question}")
        return [float(word) for word in answer.split()]

    def peak(self):
        """Peak memory (MB)."""
        status = Path("/proc", str(self.process.pid), "status").read_text()
        return int(status.split("VmHWM:")[1].split()[0]) / 1024

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def measure(workload, threads, rounds, python, ours):
    """Rounds of (wall, CPU) milliseconds of an update, and peak memory (MB) in a process of its own, by program."""
    update = [ours / "update", "--workload", workload, "--threads", threads]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*map(str, update), "--write", folder], check=True)
        peer = lambda name: [python, BENCH / "peers" / f"{name}_update.py", folder, WORKLOADS[workload], threads]
        commands = {"copq": [*update, "--serve"], "torch": peer("torch"), "jax": peer("jax")}
        servers = {name: Server(command, threads) for name, command in commands.items()}
        check(servers)
        times = interleave(servers, PROGRAMS, UPDATES, rounds, f"{workload}, {threads} thread(s)")
        peaks = {}
        for name, (server, _) in PROGRAMS.items():
            alone = Server(commands[server], threads)
            alone.ask("time", name, UPDATES)
            peaks[name] = alone.peak()
            alone.close()
    return times, peaks


def interleave(servers, programs, count, rounds, what):
    """Rounds of (wall, CPU) milliseconds by program; ends the servers."""
    times = {name: [] for name in programs}
    for round in range(rounds + 2):
        print(f"\r{what}: round {round + 1} of {rounds + 2}", end="", file=sys.stderr)
        for name, (server, _) in programs.items():
            time = servers[server].ask("time", name, count)
            # The first rounds warm up.
            if round > 1:
                times[name].append(time)
    print(file=sys.stderr)
    for server in servers.values():
        server.close()
    return times


def check(servers):
    """Ends the program unless the losses of the first updates agree."""
    wanted = servers["copq"].ask("check", "copq", UPDATES)
    for name in CHECKED:
        losses = servers[PROGRAMS[name][0]].ask("check", name, UPDATES)
        # Some losses pass through zero.
        scale = max(map(abs, wanted))
        worst = max(abs(a - b) for a, b in zip(losses, wanted, strict=True)) / scale
        print(f"losses of {name:<9} differ from copq's by at most {worst:.1e} of the largest", file=sys.stderr)
        if not worst < TOLERANCE:
            sys.exit(f"{name} does not compute the same: {losses} and {wanted}")


def text(values, digits=2):
    values = list(values)
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f}-{max(values):.{digits}f})"


def table(workload, threads, times, peaks):
    lines = [
        f"### {workload}, {threads} thread{'s' * (threads > 1)}",
        "",
        "| program | ms an update | CPU ms | to copq | to the products | peak MB |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for name, (_, label) in PROGRAMS.items():
        wall, cpu = zip(*times[name])
        ratios = f"{ratio(times, name, 'copq')} | {ratio(times, name, 'products')}"
        lines.append(f"| {label} | {text(wall)} | {text(cpu)} | {ratios} | {peaks[name]:.0f} |")
    return "\n".join(lines) + "\n"


def steps_table(times):
    lines = ["| training | steps a second | ms a step | to copq's TD3 |", "|---|--:|--:|--:|"]
    for name, (_, label) in TRAININGS.items():
        wall, _ = zip(*times[name])
        lines.append(f"| {label} | {1e3 / statistics.median(wall):.0f} | {text(wall)} | {ratio(times, name, 'td3')} |")
    return "\n".join(lines) + "\n"


def ratio(times, name, to):
    """Of neighbouring rounds, on the wall."""
    return text(a[0] / b[0] for a, b in zip(times[name], times[to]))


def machine(python):
    """What ran where."""
    model = next(line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name"))
    flags = next(line for line in open("/proc/cpuinfo") if line.startswith("flags")).split()
    widest = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "no AVX2"
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    code = "import jax, torch; print(f'PyTorch {torch.__version__}, JAX {jax.__version__}')"
    peers = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    load = os.getloadavg()[0]
    return (
        f"{model}, {os.cpu_count()} cores, {widest}; {platform.system()} {platform.release()}; rustc {rustc}; "
        f"Python {platform.python_version()}, {peers}; load {load:.1f} at the start."
    )


def updates(args, head, python, ours):
    tables, rows = [head], []
    for workload in [part for part in args.parts if part in WORKLOADS]:
        for threads in args.threads:
            times, peaks = measure(workload, threads, args.rounds, python, ours)
            tables.append(table(workload, threads, times, peaks))
            rows += [(workload, threads, name, i, *time) for name in times for i, time in enumerate(times[name])]
            print(tables[-1])
    if rows:
        (RESULTS / "update.md").write_text("\n".join(tables))
        with open(RESULTS / "update.csv", "w", newline="") as file:
            names = ("workload", "threads", "program", "round", "wall_ms", "cpu_ms")
            csv.writer(file, lineterminator="\n").writerows([names, *rows])
        subprocess.run([ours / "chart", RESULTS / "update.csv", RESULTS / "update.svg"], check=True)


def steps(args, head, python, ours):
    commands = {"copq": [ours / "td3-steps"], "peers": [python, BENCH / "peers" / "td3_steps.py", 1]}
    servers = {name: Server(command, 1) for name, command in commands.items()}
    times = interleave(servers, TRAININGS, STEPS, args.rounds, "whole steps, 1 thread")
    (RESULTS / "steps.md").write_text(head + "\n" + steps_table(times))
    print(steps_table(times))


def ours_alone(args, head, ours):
    """What needs no peers: the projections' shares, and how time and memory grow."""
    for name, words in [("projections", []), ("scaling", [RESULTS / "scaling.csv"])]:
        if name in args.parts:
            run = subprocess.run([ours / name, *words], capture_output=True, text=True, check=True)
            (RESULTS / f"{name}.md").write_text(head.split("\n")[0] + "\n\n" + run.stdout)
            print(run.stdout)


def main():
    parts = [*WORKLOADS, "steps", "projections", "scaling"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", default=parts, help=f"what to measure: {', '.join(parts)}")
    parser.add_argument("--rounds", type=int, default=31, help="interleaved rounds [31]")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="thread counts [1 2]")
    parser.add_argument("--python", help="an interpreter that has the peers, instead of a private environment")
    args = parser.parse_args()
    if unknown := set(args.parts) - set(parts):
        parser.error(f"{', '.join(unknown)}: wanted some of {', '.join(parts)}")
    python, ours = args.python or environment(), build("steps" in args.parts)
    RESULTS.mkdir(exist_ok=True)
    head = (
        f"{machine(python)}\n\nMedians (smallest-largest) of {args.rounds} interleaved rounds of {UPDATES} updates, or "
        f"of {STEPS} environment steps; ratios are of neighbouring rounds.\n"
    )
    updates(args, head, python, ours)
    if "steps" in args.parts:
        steps(args, head, python, ours)
    ours_alone(args, head, ours)


if __name__ == "__main__":
    main()
