"""Opens a run's folder without copq, with pandas and safetensors.

    python read_run.py runs/FOLDER
"""

import sys
import tomllib
from pathlib import Path

import pandas
from safetensors.numpy import load_file

run = Path(sys.argv[1])
config = tomllib.loads((run / "config.toml").read_text())  # [plan], [plan.run], [settings], [made_with]
print(config["plan"]["method"], "on", config["plan"]["task"], "seed", config["plan"]["run"]["seed"])

# One row per interval of training: losses, values and bounds by objective, returns of its episodes.
metrics = pandas.read_csv(run / "metrics.csv", index_col="step")
print(f"metrics: {len(metrics)} rows to step {metrics.index[-1]}, {', '.join(metrics.columns[:4])} ...")

# One row per evaluation: the weighted total and each objective's return over its episodes.
evaluations = pandas.read_csv(run / "evaluations.csv", index_col="step")
means = evaluations.filter(regex="^(weighted_total|return/.*)/mean$")
print(means.round(1).to_string())

# The best policy so far: named arrays, with texts as bytes (copq::Policy describes them all).
best = run / "policy-best.safetensors"
policy = load_file(best if best.exists() else run / "policy.safetensors")
print("objectives:", ", ".join(policy["policy/objectives"].tobytes().decode().split("\n")))
print("weights:", *(f"{name} {array.shape}" for name, array in policy.items() if "weight" in name))
