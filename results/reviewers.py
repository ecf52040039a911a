#!/usr/bin/env python3
"""Tables of results/README.md, "What the paper's reviewers asked", from the runs in results/.

How often the bound clips, by task: rows of metrics.csv from 10,000 steps after the first update on.
How far critics are from the actual returns, early and late: coverage.csv of the protocol.

    python3 results/reviewers.py
"""

import csv
from math import isnan, nan, sqrt
from pathlib import Path
from statistics import mean, median

RESULTS = Path(__file__).parent

# With critics that have learned for fewer steps, clipping is a matter of chance.
UNTRAINED = 10_000

TASKS = {
    "hopper, protocol": "protocol/*",
    "hopper, default, rapier": "hopper-rapier/*",
    "hopper, default, MuJoCo": "hopper-mujoco/cop-td3-*",
    "walker2d, default, MuJoCo": "walker2d-mujoco/cop-td3-*",
    "walker2d, 20,000 steps": "robots/*walker2d*",
    "halfcheetah, 20,000 steps": "robots/*halfcheetah*",
    "ant, 20,000 steps": "robots/*ant*",
    "humanoid, 20,000 steps": "robots/*humanoid*",
    "hopper under a limit, `cop-cal`": "hopper-mujoco-constrained/cop-cal*",
    "the same, 500,000 steps": "limits/cop-cal-s*",
    "the same with c = 0.1, 60,000 steps": "hopper-mujoco-augmentation/cop-cal*",
    "the same with c = 0.1, 500,000 steps": "limits/cop-cal-c0.1-s*",
    "Safety-Gymnasium's hopper, `cop-cal`": "python/safety-hopper-cop-cal*",
}
PAIRS = ["correlation/safety/velocity", "correlation/cost/reward"]

ARMS = {
    "`base`": "base",
    "half the pessimism": "half-pessimism",
    "clipped double-Q": "scalarised-min",
    "without FAMO": "no-famo",
    "normalised, LeCun's": "normalised",
    "noise of 0.3": "noise-0.3",
    "FAMO with L2": "famo-l2",
    "OAC": "oac",
    "clipped double-Q, OAC": "scalarised-min-oac",
    "uniform warm-up": "warm-up-uniform",
    "the policy's warm-up": "warm-up-policy",
}


def number(cell):
    try:
        return float(cell)
    except ValueError:
        return cell or nan


def read(file):
    """The rows of a table."""
    with open(file, newline="") as text:
        return [{name: number(cell) for name, cell in row.items()} for row in csv.DictReader(text)]


def clips(folder):
    """The rows of a run whose bound clips, once its critics know something."""
    rows = [row for row in read(folder / "metrics.csv") if not isnan(row.get("clip_rate", nan))]
    rows = [row for row in rows if row["step"] >= rows[0]["step"] + UNTRAINED]
    return rows if any(row["clip_rate"] > 0 for row in rows) else []


def pearson(pairs):
    xs, ys = zip(*pairs)
    x0, y0 = mean(xs), mean(ys)
    product = sum((x - x0) * (y - y0) for x, y in pairs)
    return product / sqrt(sum((x - x0) ** 2 for x in xs) * sum((y - y0) ** 2 for y in ys))


def span(numbers, digits):
    low, high = f"{min(numbers):.{digits}f}", f"{max(numbers):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def clip_table():
    print("| task | runs | clipped, % of rows | at most | correlation | goes with it by |")
    print("|---|--:|--:|--:|--:|--:|")
    for task, pattern in TASKS.items():
        folders = [file.parent for file in sorted(RESULTS.glob(f"{pattern}/metrics.csv"))]
        runs = [rows for rows in map(clips, folders) if rows]
        rates = [100 * mean(row["clip_rate"] for row in rows) for rows in runs]
        highest = 100 * max(row["clip_rate"] for rows in runs for row in rows)
        pair = next((pair for pair in PAIRS if pair in runs[0][0]), None)
        known = [[(row[pair], row["clip_rate"]) for row in rows] for rows in runs if pair]
        correlations = [span([mean(x for x, _ in run) for run in known], 2)] if known else []
        goes = [span([pearson(run) for run in known], 2)] if known else []
        cells = [span(rates, 1), f"{highest:.1f}", *(correlations or [""]), *(goes or [""])]
        print(f"| {task} | {len(runs)} | {' | '.join(cells)} |")


def by_limit():
    """Clipped rows by the multiplier, in runs under a limit."""
    print("| run | lambda below 0.001 | to 0.1 | to 1 | above |")
    print("|---|--:|--:|--:|--:|")
    edges = [0.0, 1e-3, 0.1, 1.0, float("inf")]
    for pattern in list(TASKS.values())[-4:]:
        for file in sorted(RESULTS.glob(f"{pattern}/metrics.csv")):
            cells = []
            for low, high in zip(edges, edges[1:]):
                rows = [row for row in clips(file.parent) if low <= row["multiplier/cost"] < high]
                rate = mean(row["clip_rate"] for row in rows) if rows else nan
                cells.append(f"{100 * rate:.0f} ({len(rows)})" if rows else "")
            print(f"| {file.parent.name} | {' | '.join(cells)} |")


def checkpoints(arm):
    """The coverage rows of the weighted total, at every checkpoint of an arm."""
    for file in sorted(RESULTS.glob(f"protocol/{arm}-s?/coverage.csv")):
        yield from (row for row in read(file) if row["objective"] == "weighted total")


def coverage_table():
    print("| arm | checkpoints | held, % | error | mean error | the rest |")
    print("|---|--:|--:|--:|--:|--:|")
    for name, arm in ARMS.items():
        for when, within in [
            ("to 75,000", lambda step: step <= 75_000),
            ("from 100,000", lambda step: step >= 100_000),
        ]:
            rows = [row for row in checkpoints(arm) if within(row["step"])]
            held = 100 * median(row["coverage"] for row in rows)
            error = median(row["rmse"] / row["q_std"] for row in rows)
            off = [row["q_mean"] - row["discounted"] for row in rows]
            mean_error = median(x / row["q_std"] for x, row in zip(off, rows))
            rest = [sqrt(max(row["rmse"] ** 2 - x**2, 0)) for x, row in zip(off, rows)]
            rest = median(x / row["q_std"] for x, row in zip(rest, rows))
            cells = f"{held:.0f} | {error:.0f} | {mean_error:+.0f} | {rest:.0f}"
            print(f"| {name}, {when} | {len(rows)} | {cells} |")


if __name__ == "__main__":
    clip_table()
    print()
    by_limit()
    print()
    coverage_table()
