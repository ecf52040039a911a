"""Holds every FOLDER/NAME.onnx against FOLDER/NAME.safetensors, which has what Rust says: python compare.py FOLDER"""

import sys
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from safetensors.numpy import load_file


def check(path):
    onnx.checker.check_model(path, full_check=True)
    model = onnx.load(path)
    assert (model.ir_version, model.opset_import[0].version, model.producer_name) == (8, 17, "copq")
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    rust = load_file(path.with_suffix(".safetensors"))
    outputs = [output.name for output in session.get_outputs()]
    assert outputs == (["action", "mean", "std"] if "sample" in rust else ["action"]), outputs
    assert session.get_inputs()[0].shape == ["batch", rust["obs"].shape[1]]
    assert all(output.shape == ["batch", 3] for output in session.get_outputs())
    differences = {}

    def compare(name, got, wanted):
        size = np.maximum(1.0, np.abs(wanted))
        differences[name] = np.max(np.abs(got.astype(np.float64) - wanted) / size)

    got = dict(zip(outputs, session.run(None, {"obs": rust["obs"]})))
    compare("action", got["action"], rust["action"])
    [one] = session.run(["action"], {"obs": rust["obs"][7:8]})
    compare("one row", one, rust["action"][7:8])
    if "sample" in rust:
        sample = got["mean"] + got["std"].astype(np.float64) * rust["noise"]
        squash = np.tanh if rust["is_squashed"][0] else np.asarray
        compare("sample", squash(sample), rust["sample"])

    # Far out, where actions end: exactly at the bounds there, and nowhere beyond.
    [far] = session.run(["action"], {"obs": rust["far_obs"]})
    low, high = rust["low"], rust["high"]
    assert ((low <= far) & (far <= high)).all(), "beyond the bounds"
    at_end = (rust["far_action"] == low) | (rust["far_action"] == high)
    assert (far[at_end] == rust["far_action"][at_end]).all(), "not at the bounds"
    print(path.stem, f"{at_end.mean():.0%} at the ends", {k: f"{v:.1e}" for k, v in differences.items()})
    for name, difference in differences.items():
        # Noise of four deviations takes their rounding with it.
        most = 2e-6 if name == "sample" else 1e-6
        assert difference <= most, f"{path.name}: {name} differs by {difference}"
    return at_end.sum()


paths = sorted(Path(sys.argv[1]).glob("*.onnx"))
ends = sum(check(path) for path in paths)
assert ends > 1000, "no action came to its end"
print(len(paths), "policies agree")
