#!/usr/bin/env python3
"""Times copq against its peers, interleaved, from the same weights and on the same batches.

    python3 bench/run.py                        everything: about half an hour on two quiet cores, after building
    python3 bench/run.py --rounds 5 walker2d    one part, with fewer rounds
    python3 bench/publish.py                    puts the tables into bench/RESULTS.md

Each part writes its own table and raw times into bench/results as soon as it is done, so that it can be run again by
itself. After each part that times updates, the chart of all such parts is drawn. With `--results`, another machine
gets its own folder.

The peers get a private environment in third_party/bench-peers (git-ignored; the first run downloads several
gigabytes, because PyPI's PyTorch includes CUDA). Every program must report the same losses before it is timed. Needs
Linux, Rust, a C and a C++ compiler, python3 with venv, crates.io and PyPI.

OmniSafe, in the part `on-policy`, needs python3.10 and old packages. It gets its own environment in
third_party/bench-omnisafe, which is as large. Without a python3.10, or with `--skip omnisafe`, it is left out.

The part `instructions` has to be asked for: it needs Valgrind, which computes fused multiply-adds one by one, and takes
most of an hour on a busy machine.

torch.compile builds C++ at its first call, before anything is timed, and keeps it in third_party/bench-peers/compiled.
On a busy machine, that may take longer than the 10 minutes allowed for an answer; `--skip compiled` leaves it out.
"""

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

from servers import VENV, Failure, Server, check, interleave, peaks
from tables import instructions_table, steps_table, updates_table, write_csv

BENCH = Path(__file__).resolve().parent
ROOT = BENCH.parent
# A multiple of every workload's actor delay, and the number of batches.
UPDATES = 20
WORKLOADS = {"walker2d": 2, "humanoid": 2, "redq": 20}  # and their actor delays
PARTS = [*WORKLOADS, "steps", "on-policy", "projections", "scaling", "instructions"]
# Programs in the order of the tables, and who serves each.
PROGRAMS = {
    "products": "copq",
    "copq": "copq",
    "learner": "copq",
    "backward": "copq",
    "careful": "copq",
    "learner-backward": "copq",
    "learner-careful": "copq",
    "scan": "jax",
    "step": "jax",
    "compiled": "torch",
    "eager": "torch",
    "autograd": "copq",
    "plain": "copq",
}
# These report no losses.
UNCHECKED = {"products", "learner", "learner-backward", "learner-careful"}
# Environment steps in a round of whole training.
STEPS = 200
TRAININGS = {"td3": "copq", "cop": "copq", "sbx": "peers", "sb3": "peers"}
# Steps in an epoch of on-policy training; who serves each program, and which of ours uses the same method.
EPOCH = 2048
ON_POLICY = {"ppo": "copq", "cppo-pid": "copq", "sbx": "peers", "sb3": "peers", "omnisafe": "omnisafe"}
SAME_METHOD = {"ppo": "ppo", "cppo-pid": "cppo-pid", "sbx": "ppo", "sb3": "ppo", "omnisafe": "cppo-pid"}
LABELS = {
    "products": "its matrix products alone (`gemm`)",
    "copq": "**copq**",
    "learner": "copq's whole learner: replay, FAMO, reports",
    "backward": "copq, `precision = \"backward\"`",
    "careful": "copq, `precision = \"careful\"`",
    "learner-backward": "copq's whole learner, `backward`",
    "learner-careful": "copq's whole learner, `careful`",
    "scan": "JAX jit, scan over updates",
    "step": "JAX jit, one update a call",
    "compiled": "PyTorch, `torch.compile`",
    "eager": "PyTorch eager, separate critics, fused Adam",
    "autograd": "candle autograd",
    "plain": "copq's plain candle networks",
    "td3": "copq, TD3 as Stable-Baselines3's",
    "cop": "copq, COP-TD3 with FAMO and OAC",
    "sbx": "SBX TD3 (JAX)",
    "sb3": "Stable-Baselines3 TD3 (PyTorch)",
}
ON_POLICY_LABELS = {
    "ppo": "copq, PPO",
    "cppo-pid": "copq, CPPOPID",
    "sbx": "SBX PPO (JAX)",
    "sb3": "Stable-Baselines3 PPO (PyTorch)",
    "omnisafe": "OmniSafe CPPOPID (PyTorch)",
}
# Programs whose instructions are counted.
COUNTED = ["products", "copq", "learner", "autograd"]


def environment(venv=VENV, requirements="requirements.txt", python=sys.executable):
    """The peers' interpreter, freshly installed if it is missing or its list of packages has changed."""
    wanted, installed = BENCH / "peers" / requirements, venv / "installed.txt"
    if not installed.exists() or installed.read_text() != wanted.read_text():
        print(f"installing {venv.name}", file=sys.stderr)
        subprocess.run([python, "-m", "venv", venv], check=True)
        subprocess.run([venv / "bin" / "pip", "install", "--quiet", "--requirement", wanted], check=True)
        installed.write_text(wanted.read_text())
    return venv / "bin" / "python"


def omnisafe(skip):
    """The interpreter that has OmniSafe, or None without python3.10 or if OmniSafe is skipped."""
    python = shutil.which("python3.10")
    if "omnisafe" in skip:
        return None
    if not python:
        print("OmniSafe is left out: it needs a python3.10, and there is none", file=sys.stderr)
        return None
    return environment(VENV.with_name("bench-omnisafe"), "requirements-omnisafe.txt", python)


def build(mujoco):
    """Builds our programs and returns their folder."""
    if mujoco:
        subprocess.run([ROOT / "scripts" / "fetch-mujoco.sh"], check=True)
    features = ["--features", "mujoco"] if mujoco else []
    subprocess.run(["cargo", "build", "--release", "--locked", "-p", "copq-bench", *features], cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"), "release").resolve()


def machine(python):
    """What ran where, with the peers' versions if they ran."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    # ARM's list has neither model name nor flags.
    model = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())
    flags = next((line for line in lines if line.startswith("flags")), "").split()
    widest = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "no AVX2"
    rustc = output(["rustc", "--version"]).split()[1]
    names = {"torch": "PyTorch", "jax": "JAX", "gymnasium": "Gymnasium", "stable_baselines3": "SB3", "sbx-rl": "SBX"}
    try:
        commit = output(["git", "-C", ROOT, "describe", "--always"]).strip()
        # The results written here do not change what is measured.
        if output(["git", "-C", ROOT, "status", "--porcelain", "-uno", "--", ".", ":!bench/results"]).strip():
            commit += "-dirty"
    except (OSError, subprocess.CalledProcessError):
        commit = "of no repository"
    ours = f"{model}, {os.cpu_count()} cores, {widest}; Linux {platform.release().split('-')[0]}; copq {commit}, rustc {rustc}"
    return f"{ours}; {versions(python, names)}" if python else ours


def versions(python, names):
    """The versions of an interpreter and of its packages."""
    code = f"from importlib.metadata import version; [print(name, version(key)) for key, name in {names}.items()]"
    return ", ".join([output([python, "--version"]).strip(), *output([python, "-c", code]).splitlines()])


def output(command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def updates(workload, args):
    """The table of one workload for each number of threads."""
    programs = {name: server for name, server in PROGRAMS.items() if name not in args.skip}
    tables, rows = [], []
    for threads in args.threads:
        title = f"{workload}, {threads} thread{'s' * (threads > 1)}"
        times, megabytes = measure(workload, threads, title, programs, args)
        tables.append(updates_table(title, LABELS, times, megabytes))
        rows.append((workload, threads, times))
    write_csv(args.results / f"{workload}.csv", rows)
    charted = [path for name in WORKLOADS if (path := args.results / f"{name}.csv").exists()]
    subprocess.run([args.programs / "chart", args.results / "updates.svg", *charted], check=True)
    return f"{args.rounds} interleaved rounds of {UPDATES} updates.\n\n" + "\n".join(tables)


def measure(workload, threads, title, programs, args):
    """Times and peak memory (MB, in a separate process) by program."""
    ours = [args.programs / "update", "--workload", workload, "--threads", threads]
    with tempfile.TemporaryDirectory() as folder:
        output([*map(str, ours), "--write", folder])
        peer = lambda name: [args.python, BENCH / "peers" / f"{name}_update.py", folder, WORKLOADS[workload], threads]
        commands = {"copq": [*ours, "--serve"], "torch": peer("torch"), "jax": peer("jax")}
        # Servers that serve none of the programs are not started, so they need not be installed.
        servers = {name: Server(commands[name], threads) for name in dict.fromkeys(programs.values())}
        check(servers, {name: server for name, server in programs.items() if name not in UNCHECKED}, UPDATES)
        times = interleave(servers, programs, UPDATES, args.rounds, title)
        for server in servers.values():
            server.close()
        return times, peaks(commands, programs, UPDATES, threads)


def steps(args):
    """The table of whole environment steps."""
    commands = {"copq": [args.programs / "training-steps"], "peers": [args.python, BENCH / "peers" / "sb3_steps.py", "td3", 1]}
    times, shares = trainings("steps", commands, TRAININGS, STEPS, args)
    return f"{args.rounds} interleaved rounds of {STEPS} environment steps, one thread.\n\n" + steps_table(
        LABELS, times, shares, "copq's TD3", dict.fromkeys(TRAININGS, "td3")
    )


def on_policy(args):
    """The table of whole epochs of on-policy training."""
    commands = {"copq": [args.programs / "training-steps"], "peers": [args.python, BENCH / "peers" / "sb3_steps.py", "ppo", 1]}
    what = f"{args.rounds} interleaved rounds of an epoch of {EPOCH} environment steps, one thread"
    if python := omnisafe(args.skip):
        commands["omnisafe"] = [python, BENCH / "peers" / "omnisafe_steps.py", 1]
        names = {"omnisafe": "OmniSafe", "torch": "PyTorch", "gymnasium": "Gymnasium", "mujoco": "MuJoCo"}
        what += f"; OmniSafe by itself: {versions(python, names)}"
    programs = {name: server for name, server in ON_POLICY.items() if server in commands}
    times, shares = trainings("on-policy", commands, programs, EPOCH, args)
    note = "Ratios are to copq's row of the same method: to its PPO, and OmniSafe's to its CPPOPID.\n"
    table = steps_table(ON_POLICY_LABELS, times, shares, "copq's same method", SAME_METHOD)
    return f"{what}.\n\n{table}\n{note}"


def trainings(part, commands, programs, steps, args):
    """Times by program, and the shares of time within our programs."""
    servers = {name: Server(command, 1) for name, command in commands.items()}
    times = interleave(servers, programs, steps, args.rounds, part)
    ours = [name for name, server in programs.items() if server == "copq"]
    shares = {name: servers["copq"].ask("shares", name, steps) for name in ours}
    for server in servers.values():
        server.close()
    write_csv(args.results / f"{part}.csv", [(part, 1, times)])
    return times, shares


def ours_alone(part, args):
    """Runs a part that has its own program and needs no peers; returns what it prints."""
    command = [args.programs / part, "--rounds", str(args.rounds), "--csv", args.results / f"{part}.csv"]
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            print(line, end="", file=sys.stderr)
            lines.append(line)
    if process.returncode:
        raise Failure(f"{part} ended with {process.returncode}")
    return "".join(lines)


def instructions(args):
    """The table of instructions in an update of walker2d; they do not depend on what else the machine does."""
    counts = {}
    for name in COUNTED:
        print(f"instructions of {name}", file=sys.stderr)
        whole = [executed(args.programs / "update", name, updates) for updates in (2, 4, 6)]
        counts[name] = [(after - before) / 2 for before, after in zip(whole, whole[1:])]
    return "Valgrind's counts, one thread, of the third and fourth update (one of them moves the actor) and of the next two, a mean each.\n\n" + instructions_table(LABELS, counts)


def executed(program, name, updates):
    """Instructions from start to end of a process that does this number of updates."""
    command = [program, "--only", "--updates", str(updates), name]
    valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    done = subprocess.run([*valgrind, *command], capture_output=True, text=True)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not collected:
        raise Failure(f"{name} under Valgrind: {done.stderr[-500:]}")
    return int(collected[1])


def run(part, args):
    before = os.getloadavg()[0]
    others = {"steps": steps, "on-policy": on_policy, "instructions": instructions}
    measured = {**dict.fromkeys(WORKLOADS, partial(updates, part)), **others}
    table = measured.get(part, partial(ours_alone, part))(args)
    load = f"load {before:.1f} before, {os.getloadavg()[0]:.1f} after"
    statistics = "" if part == "instructions" else "Medians (smallest-largest), ratios of neighbouring rounds; "
    has_peers = part in WORKLOADS or part in ("steps", "on-policy")
    head = f"{machine(args.python if has_peers else None)}; {load}. {statistics}"
    (args.results / f"{part}.md").write_text(head + table)
    print(table)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    usual = [part for part in PARTS if part != "instructions"]
    parser.add_argument("parts", nargs="*", default=usual, help=f"what to measure: {', '.join(PARTS)} [all but the last]")
    parser.add_argument("--rounds", type=int, default=15, help="interleaved rounds, after two warm-up rounds [15]")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="thread counts of an update [1 2]")
    parser.add_argument("--skip", nargs="+", default=[], help="programs to leave out, such as compiled")
    parser.add_argument(
        "--results", type=Path, default=BENCH / "results", help="the folder for tables, one per machine [bench/results]"
    )
    parser.add_argument("--python", help="an interpreter that has the peers, instead of a private environment")
    parser.add_argument("--programs", type=Path, help="the folder of our programs, instead of building them")
    args = parser.parse_args()
    for chosen, known in [(args.parts, PARTS), (args.skip, PROGRAMS.keys() - {"copq", "products"} | {"omnisafe"})]:
        if unknown := set(chosen) - set(known):
            parser.error(f"{', '.join(sorted(unknown))}: wanted some of {', '.join(known)}")
    args.python = args.python or (environment() if {*WORKLOADS, "steps", "on-policy"} & {*args.parts} else None)
    args.programs = args.programs or build(bool({"steps", "on-policy"} & {*args.parts}))
    args.results.mkdir(parents=True, exist_ok=True)
    began, failed = time.monotonic(), []
    for i, part in enumerate(args.parts):
        print(f"== {part}, {i + 1} of {len(args.parts)}, after {time.monotonic() - began:.0f} s", file=sys.stderr)
        try:
            run(part, args)
        except (Failure, OSError, subprocess.CalledProcessError) as error:
            print(f"\n{part}: {error}", file=sys.stderr)
            failed.append(part)
    if failed:
        sys.exit(f"not measured: {' '.join(failed)}")


if __name__ == "__main__":
    main()
