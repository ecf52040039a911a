"""Acts with a policy from a run's folder, using only numpy: python act_numpy.py runs/FOLDER/policy-best.safetensors"""

import json
import sys

import numpy as np

with open(sys.argv[1], "rb") as file:  # the header's length in 8 bytes, a header of JSON, then all arrays' bytes
    header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
    data = file.read()
header.pop("__metadata__", None)
types = {"F32": "<f4", "F64": "<f8", "U64": "<u8", "U8": "u1"}
flat = {name: np.frombuffer(data[slice(*a["data_offsets"])], types[a["dtype"]]) for name, a in header.items()}
p = {name: array.reshape(header[name]["shape"]) for name, array in flat.items()}
kind, activation, task = (p[f"policy/{name}"].tobytes().decode() for name in ("kind", "activation", "task"))
activate = {"relu": lambda x: np.maximum(x, 0), "tanh": np.tanh, "silu": lambda x: x / (1 + np.exp(-x))}[activation]


def act(obs):
    """The environment's own actions for raw observations, one row each."""
    x = obs.astype(np.float64)
    if p.get("normaliser/count", [0])[0] > 1:
        mean, squares = p["normaliser/mean"], p["normaliser/squares"]  # later components stay as they are
        std = np.maximum(np.sqrt(squares / (p["normaliser/count"] - 1.0)), 0.01)
        x[:, : len(mean)] = np.clip((x[:, : len(mean)] - mean) / std, -5, 5)
    for layer in range(len(p["policy/hidden"]) + 1):
        x = (activate(x) if layer else x) @ p[f"actor/layer.{layer}.weight"].T + p[f"actor/layer.{layer}.bias"]
    low, high = p["policy/action_low"], p["policy/action_high"]
    mean = x[:, : len(low)]  # a gaussian policy has log standard deviations after them
    unit = np.clip(mean, -1, 1) if kind == "normal" else np.tanh(mean)
    return low + (high - low) * (unit + 1) / 2


print(kind, "policy for", task)
print(np.round(act(np.random.default_rng(0).normal(size=(4, p["policy/obs_len"][0])).astype(np.float32)), 4))
