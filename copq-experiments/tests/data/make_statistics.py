"""SciPy's and NumPy's numbers for src/statistics: python3 make_statistics.py (needs scipy)."""

import json
from pathlib import Path

import numpy as np
import scipy
from scipy import stats


def main():
    rng = np.random.default_rng(3)
    cases = []
    for n, m in [(3, 3), (4, 5), (5, 5), (7, 3), (10, 12), (31, 20), (2, 3)]:
        first = np.round(rng.normal(100, 30, n), 1)
        second = np.round(rng.normal(110, 40, m), 1)
        second[0] = first[0]  # a tie
        steps = np.cumsum(rng.integers(1, 9, n)).astype(float)
        welch = stats.ttest_ind(first, second, equal_var=False).confidence_interval(0.95)
        student = stats.ttest_1samp(first, 100).confidence_interval(0.95)
        cases.append(
            {
                "first": first.tolist(),
                "second": second.tolist(),
                "steps": steps.tolist(),
                "mean": float(np.mean(first)),
                "std": float(np.std(first)),
                "iqm": float(stats.trim_mean(first, 0.25)),
                "improvement": float(stats.mannwhitneyu(first, second).statistic / (n * m)),
                "welch": [float(welch.low), float(welch.high)],
                "student": [float(student.low - 100), float(student.high - 100)],
                "area": float(np.trapezoid(first, steps) / (steps[-1] - steps[0])),
            }
        )
    out = {"made_by": f"NumPy {np.__version__}, SciPy {scipy.__version__}", "cases": cases}
    (Path(__file__).parent / "statistics.json").write_text(json.dumps(out) + "\n")


if __name__ == "__main__":
    main()
