#!/usr/bin/env python3
"""Ten thousand runs, planned, listed and reported: how long it takes, and how much memory.

    python3 scripts/scale.py target/release/copq          # 10,000 runs in a folder of their own, which goes again
    python3 scripts/scale.py target/release/copq 1000

One real, tiny run of each of 20 methods on 5 tasks leaves the files; the seeds are copies of it with other numbers, as long as
runs of 300,000 steps leave (61 evaluations, 300 rows of metrics).
"""

import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

TASKS = ["a/hopper", "a/walker2d", "a/ant", "a/halfcheetah", "a/humanoid"]
METHODS = 20


def sweep_file(seeds):
    arms = "".join(f'\n[[arm]]\nname = "tau-{i}"\nset = "tau=0.{i:02}"\n' for i in range(1, METHODS + 1))
    tasks = ", ".join(f'"{task}"' for task in TASKS)
    return f"""out = "runs"

[all]
steps = 300000
set = ["networks.hidden=[8,8]", "batch=8", "start_steps=400000"]

[grid]
task = [{tasks}]
seed = [{", ".join(map(str, range(seeds)))}]
{arms}"""


def timed(copq, *arguments, folder):
    """What it prints, its seconds, those of a processor, and its memory at most (MB)."""
    began = time.monotonic()
    with tempfile.TemporaryFile("w+") as out:
        child = subprocess.Popen([copq, *arguments], cwd=folder, stdout=out)
        _, status, used = os.wait4(child.pid, 0)
        assert status == 0, arguments
        out.seek(0)
        return out.read(), time.monotonic() - began, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def table(header, steps, rng):
    lines = [header]
    columns = header.count(",")
    for step in steps:
        lines.append(",".join([str(step), *(f"{1000 * rng.random():.10f}" for _ in range(columns))]))
    return "\n".join(lines) + "\n"


def fill(copq, folder, runs):
    """Gives every run's folder the files of a finished one."""
    template = folder / "template"
    subprocess.run(
        [copq, "train", "--steps", "300", "--eval-every", "300", "--eval-episodes", "1", "--log-every", "100",
         "--set", "networks.hidden=[8,8]", "--set", "batch=8", "--set", "start_steps=100", "--out", template],
        check=True, capture_output=True)
    heads = {name: (template / name).read_text().split("\n", 1)[0]
             for name in ["metrics.csv", "evaluations.csv", "timings.csv"]}
    rng = random.Random(0)
    metrics = [table(heads["metrics.csv"], range(1000, 300001, 1000), rng) for _ in range(20)]
    evaluations = [table(heads["evaluations.csv"], range(0, 300001, 5000), rng) for _ in range(20)]
    timings = [table(heads["timings.csv"], range(1000, 300001, 1000), rng) for _ in range(20)]
    config = (template / "config.toml").read_text()
    for number, (run, task, tau, seed) in enumerate(runs):
        path = folder / run
        path.mkdir(parents=True)
        text = config.replace('task = "a/hopper"', f'task = "{task}"').replace("tau = 0.005", f"tau = {tau}")
        (path / "config.toml").write_text(text.replace("seed = 0", f"seed = {seed}").replace("steps = 300\n", "steps = 300000\n"))
        for name, tables in [("metrics.csv", metrics), ("evaluations.csv", evaluations), ("timings.csv", timings)]:
            (path / name).write_text(tables[number % len(tables)])


def main():
    copq = pathlib.Path(sys.argv[1]).resolve()
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        (folder / "scale.toml").write_text(sweep_file(max(1, count // (METHODS * len(TASKS)))))
        plan, seconds, cpu, memory = timed(copq, "sweep", "plan", "scale.toml", folder=folder)
        lines = plan.splitlines()
        print(f"plan     {len(lines)} runs: {seconds:.1f} s ({cpu:.1f} s of a processor), {memory:.0f} MB at most")
        runs = []
        for line in lines:
            words = line.split()
            options = dict(zip(words, words[1:]))
            tau = next(word.split("=")[1] for word in words if word.startswith("tau="))
            runs.append((words[1], options["--task"], tau, options["--seed"]))
        fill(copq, folder, runs)
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6
        print(f"         {size:.0f} MB of files")
        for name, arguments in [
            ("status", ["sweep", "status", "scale.toml"]),
            ("report", ["sweep", "report", "scale.toml", "--out", "report.html"]),
        ]:
            _, seconds, cpu, memory = timed(copq, *arguments, folder=folder)
            print(f"{name:8} {seconds:.1f} s ({cpu:.1f} s of a processor), {memory:.0f} MB at most")
        page = (folder / "report.html").stat().st_size / 1e6
        print(f"         a page of {page:.1f} MB")
    finally:
        shutil.rmtree(folder)


main()
