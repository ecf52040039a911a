#!/usr/bin/env python3
"""What the house looks like in numbers: python3 scripts/figures.py [FOLDER ...] (default: the crates' sources).

Function bodies (lines between the braces), bounds an impl, doc examples a thousand lines, lines over 100 columns, `let (a, b) = (x, y)`
and iterator combinators a thousand lines. A text walker, not a parser: good for comparing one state of a repository with another.
"""
import re
import sys
from pathlib import Path

COMBINATORS = r"\.(map|filter|filter_map|flat_map|zip|enumerate|chain|fold|for_each|try_for_each|take|skip|step_by|rev|any|all|find|position|sum|scan)\("


def bodies(lines):
    """Lengths of function bodies, by matching braces from each `fn`."""
    lengths = []
    for i, line in enumerate(lines):
        if not re.match(r"\s*(pub(\([a-z]+\))? )?(const |async |unsafe |extern \"C\" )*fn ", line):
            continue
        depth, start = 0, None
        for j in range(i, len(lines)):
            text = re.sub(r'"(\\.|[^"\\])*"|//.*|\'[{}]\'', "", lines[j])
            if start is None and ";" in text and "{" not in text:
                break
            if start is None and "{" in text:
                start = j
            depth += text.count("{") - text.count("}")
            if start is not None and depth <= 0:
                lengths.append(max(j - start - 1, 1))
                break
    return lengths


def main():
    folders = [Path(p) for p in sys.argv[1:]] or sorted(Path(".").glob("copq*/src"))
    files = [f for folder in folders for f in sorted(folder.rglob("*.rs"))]
    texts = [f.read_text() for f in files]
    lines = [line for text in texts for line in text.splitlines()]
    code = [line for line in lines if line.strip() and not line.strip().startswith("//")]
    kloc = len(code) / 1000
    lengths = sorted(n for text in texts for n in bodies(text.splitlines()))
    bounds = sorted(h.count(":") - 2 * h.count("::") for text in texts for h in re.findall(r"^\s*impl<[^{]*", text, re.M))
    examples = sum(len(re.findall(r"^\s*//[/!] ```", text, re.M)) // 2 for text in texts)
    pairs = sum(len(re.findall(r"let \([^)]*\) = \(", line)) for line in code)
    combinators = sum(len(re.findall(COMBINATORS, line)) for line in code)
    at = lambda share: lengths[min(int(share * len(lengths)), len(lengths) - 1)] if lengths else 0
    print(f"files {len(files)}, lines of code {len(code)}, longest file {max(len(t.splitlines()) for t in texts)}")
    print(f"function body, median / p90 / max lines: {at(0.5)} / {at(0.9)} / {lengths[-1]}")
    print(f"bounds an impl, median / max: {bounds[len(bounds) // 2] if bounds else 0} / {bounds[-1] if bounds else 0}")
    print(f"doc examples a kloc: {examples / kloc:.1f}")
    print(f"lines over 100 columns: {100 * sum(len(line) > 100 for line in lines) / len(lines):.1f} %")
    print(f"let (a, b) = (x, y) a kloc: {pairs / kloc:.1f}")
    print(f"iterator combinators a kloc: {combinators / kloc:.0f}")


if __name__ == "__main__":
    main()
