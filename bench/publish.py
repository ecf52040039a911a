#!/usr/bin/env python3
"""Copies what bench/run.py measured into bench/RESULTS.md.

    python3 bench/publish.py

The table bench/results/NAME, or a link to it if it is a chart, goes between a line `<!-- results/NAME -->` and the next
`<!-- end -->`. What has not been measured stays as it is.
"""

import re
from pathlib import Path

BENCH = Path(__file__).resolve().parent


def content(path, old):
    if not path.exists():
        print(f"{path}: not measured")
        return old
    if path.suffix == ".svg":
        return f"![Medians as bars]({path.relative_to(BENCH)})"
    return path.read_text().strip()


def main():
    page = BENCH / "RESULTS.md"
    block = re.compile(r"(<!-- (results/\S+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
    fill = lambda match: f"{match[1]}\n{content(BENCH / match[2], match[3].strip())}\n\n{match[4]}"
    page.write_text(block.sub(fill, page.read_text()))


if __name__ == "__main__":
    main()
