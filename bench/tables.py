"""Markdown and CSV of what bench/run.py measured: rounds of (wall, CPU) milliseconds by program."""

import csv
import statistics


def updates_table(title, labels, times, peaks):
    lines = [
        f"### {title}",
        "",
        "| program | ms an update | CPU ms | to copq | to the products | peak MB |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for name in times:
        wall, cpu = zip(*times[name])
        ratios = f"{ratio(times, name, 'copq')} | {ratio(times, name, 'products')}"
        lines.append(f"| {labels[name]} | {text(wall)} | {text(cpu)} | {ratios} | {peaks[name]:.0f} |")
    return "\n".join(lines) + "\n"


def steps_table(labels, times, shares, reference, references):
    """`references` gives the program by whose times each program's are divided; `reference` is its name in the head."""
    lines = [
        f"| training | steps a second | ms a step | CPU ms | to {reference} |",
        "|---|--:|--:|--:|--:|",
    ]
    for name in times:
        wall, cpu = zip(*times[name])
        speed, to_ours = 1e3 / statistics.median(wall), ratio(times, name, references[name])
        lines.append(f"| {labels[name]} | {speed:.0f} | {text(wall)} | {text(cpu)} | {to_ours} |")
    lines += ["", "| share of the time, % | updates | environment | acting | all else |", "|---|--:|--:|--:|--:|"]
    for name, parts in shares.items():
        cells = " | ".join(f"{100 * part:.1f}" for part in [*parts, 1 - sum(parts)])
        lines.append(f"| {labels[name]} | {cells} |")
    return "\n".join(lines) + "\n"


def instructions_table(labels, counts):
    lines = ["| program | million instructions an update | to copq |", "|---|--:|--:|"]
    for name, parts in counts.items():
        millions = " and ".join(f"{part / 1e6:.2f}" for part in parts)
        lines.append(f"| {labels[name]} | {millions} | {sum(parts) / sum(counts['copq']):.2f} |")
    return "\n".join(lines) + "\n"


def text(values, digits=2):
    """`median (smallest-largest)`"""
    values = list(values)
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f}-{max(values):.{digits}f})"


def ratio(times, name, to):
    """The ratios of wall times in neighbouring rounds."""
    return text(a[0] / b[0] for a, b in zip(times[name], times[to]))


def write_csv(path, rows):
    """Raw times: rows of (what, threads, times)."""
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["workload", "threads", "program", "round", "wall_ms", "cpu_ms"])
        for workload, threads, times in rows:
            for name, rounds in times.items():
                out.writerows([workload, threads, name, i, *time] for i, time in enumerate(rounds))
