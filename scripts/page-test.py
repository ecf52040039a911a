#!/usr/bin/env python3
"""The report's page in a real browser: no error on its console, values under the pointer equal to the CSVs', boxes that show and hide
without a script, and everything there without scripts.

    python3 scripts/page-test.py target/debug/copq [results/on-policy]

Needs Debian's chromium (apt-get install chromium); says so where there is none.
"""

import csv
import html
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

# Points at the middle of every panel, then hides the first method, and writes down what the page shows.
PROBE = """
<script>
const seen = { tips: [], errors: window.seenErrors };
for (const figure of document.querySelectorAll("figure.curves")) {
  if (getComputedStyle(figure).display === "none") continue;
  const svg = figure.querySelector("svg");
  for (const group of svg.querySelectorAll("g.panel")) {
    const [left, right, top, bottom] = group.dataset.frame.split(" ").map(Number);
    const at = new DOMPoint((left + right) / 2, (top + bottom) / 2).matrixTransform(svg.getScreenCTM());
    figure.dispatchEvent(new PointerEvent("pointermove", { clientX: at.x, clientY: at.y, bubbles: true }));
    seen.tips.push([...figure.querySelectorAll(".tip > *")].map((row) => row.textContent));
  }
}
const display = () => getComputedStyle(document.querySelector("g.panel .s0")).display;
const thin = () => { const line = document.querySelector(".thin"); return line ? getComputedStyle(line).display : null; };
seen.before = [display(), thin()];
document.querySelector("#m0").click();
document.querySelector("#seeds").click();
seen.after = [display(), thin()];
seen.wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
document.body.append(Object.assign(document.createElement("pre"), { id: "seen", textContent: JSON.stringify(seen) }));
</script>
"""
ERRORS = '<script>window.seenErrors = []; addEventListener("error", (e) => seenErrors.push(e.message));</script>'


def chromium(page, *arguments):
    with tempfile.TemporaryDirectory() as profile:
        return subprocess.run(
            [shutil.which("chromium"), "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", f"--user-data-dir={profile}",
             "--enable-logging=stderr", *arguments, f"file://{page}"],
            capture_output=True, text=True, timeout=120)


def means(folders, column):
    """Step to mean and deviation over the seeds, where all have it."""
    seeds = []
    for folder in folders:
        rows = csv.DictReader((folder / "evaluations.csv").open())
        seeds.append({int(row["step"]): float(row[column]) for row in rows})
    shared = set.intersection(*map(set, seeds))
    return {step: (statistics.fmean(v := [s[step] for s in seeds]), statistics.pstdev(v)) for step in shared}


def number(text):
    return float(text.replace(",", "").replace("\u2212", "-"))


def check_tip(tip, runs, quantity):
    """Every row of a tip against the files."""
    step = int(re.search(r"at step ([\d,]+)$", tip[0])[1].replace(",", ""))
    column = "weighted_total/mean" if quantity == "weighted total" else f"return/{quantity}/mean"
    for row in tip[1:]:
        parts = re.fullmatch(r"(.+): (\S+) \((\S+) to (\S+); (\d+) seeds?\)(?: at ([\d,]+))?", row)
        label, middle, low, high, seeds, own = parts.groups()
        mean, std = means(runs[label], column)[int((own or str(step)).replace(",", ""))]
        assert int(seeds) == len(runs[label]), row
        for got, wanted in [(middle, mean), (low, mean - std), (high, mean + std)]:
            assert abs(number(got) - wanted) <= 1e-4 * (1 + abs(wanted)), f"{row}: {got}, not {wanted}"


def main():
    browser = shutil.which("chromium")
    # Ubuntu's, of a snap, sees another /tmp.
    if not browser or os.path.realpath(browser).startswith("/snap/") or "/snap/" in browser:
        print("!! SKIPPED: the page in a browser, for there is no chromium (Debian: apt-get install chromium)")
        return
    copq = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "results/on-policy")
    runs = {}
    for config in sorted(folder.glob("*/config.toml")):
        runs.setdefault(config.parent.name.rsplit("-s", 1)[0], []).append(config.parent)
    with tempfile.TemporaryDirectory() as work:
        page = pathlib.Path(work) / "report.html"
        subprocess.run([copq, "report", folder, "--out", page], check=True, stdout=subprocess.DEVNULL)
        text = page.read_text()
        assert not re.search(r"(src|href)=.?https?:", text), "something is elsewhere"
        assert text.count("<polyline") > 100, "the curves are there without scripts"
        probed = pathlib.Path(work) / "probed.html"
        probed.write_text(text.replace("<head>", f"<head>{ERRORS}", 1).replace("</body>", f"{PROBE}</body>", 1))
        for width, scheme in [(1280, 1), (390, 0)]:
            shown = chromium(probed, f"--window-size={width},900", f"--blink-settings=preferredColorScheme={scheme}", "--dump-dom")
            console = [line for line in shown.stderr.splitlines() if "CONSOLE" in line]
            assert not console, console
            seen = json.loads(html.unescape(re.search(r'<pre id="seen">(.*?)</pre>', shown.stdout, re.S)[1]))
            assert seen["errors"] == [] and seen["wide"] <= 0, (seen["errors"], seen["wide"])
            assert seen["before"] == ["inline", "none"] and seen["after"] == ["none", "inline"], seen
            tips = [tip for tip in seen["tips"] if tip]
            quantities = ["weighted total", *re.findall(r"return/([^/]+)/mean", (config.parent / "evaluations.csv").open().readline())]
            for tip, quantity in zip(tips, quantities):
                assert len(tip) == 1 + len(runs), tip
                check_tip(tip, runs, quantity)
            print(f"{width} pixels wide: {len(tips)} panels answer, {len(quantities)} of evaluations equal the CSVs'")


main()
