"""Acts by a policy in a run's folder with numpy alone: the file read by hand, the network in a loop.

    python act_numpy.py runs/FOLDER/policy-best.safetensors
"""

import json
import sys

import numpy as np

# A safetensors file: the header's length in 8 bytes, a header of JSON, then all arrays' bytes.
with open(sys.argv[1], "rb") as file:
    header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
    data = file.read()
arrays = {}
for name, array in header.items():
    if name != "__metadata__":
        first, end = array["data_offsets"]
        dtype = {"F32": "<f4", "F64": "<f8", "U64": "<u8", "U8": "u1"}[array["dtype"]]
        arrays[name] = np.frombuffer(data[first:end], dtype).reshape(array["shape"])
text = {name: array.tobytes().decode() for name, array in arrays.items() if array.dtype == np.uint8}


def act(obs):
    """The environment's own actions for raw observations, a row each."""
    x = obs.astype(np.float64)
    if arrays.get("normaliser/count", [0])[0] >= 2:
        mean = arrays["normaliser/mean"]  # the components after these stay as they are
        std = np.sqrt(arrays["normaliser/squares"] / (arrays["normaliser/count"] - 1.0))
        measured = (x[:, : len(mean)] - mean) / np.maximum(std, 0.01)
        x[:, : len(mean)] = np.clip(measured, -5, 5)
    for layer in range(len(arrays["policy/hidden"]) + 1):
        if layer > 0:
            relu, silu = lambda x: np.maximum(x, 0), lambda x: x / (1 + np.exp(-x))
            x = {"relu": relu, "tanh": np.tanh, "silu": silu}[text["policy/activation"]](x)
        x = x @ arrays[f"actor/layer.{layer}.weight"].T + arrays[f"actor/layer.{layer}.bias"]
    low, high = arrays["policy/action_low"], arrays["policy/action_high"]
    mean = x[:, : len(low)]  # a gaussian policy has log standard deviations after them
    unit = np.clip(mean, -1, 1) if text["policy/kind"] == "normal" else np.tanh(mean)
    return low + (high - low) * (unit + 1) / 2


print(text["policy/kind"], "policy for", text["policy/task"])
length = arrays["policy/obs_len"][0]
print(np.round(act(np.random.default_rng(0).normal(size=(4, length)).astype(np.float32)), 4))
