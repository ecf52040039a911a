"""Acts with a policy written by `copq export --format onnx`, using only onnxruntime.

    python act_onnx.py runs/FOLDER/policy.onnx
"""

import sys

import numpy as np
import onnxruntime

session = onnxruntime.InferenceSession(sys.argv[1])
about = session.get_modelmeta().custom_metadata_map  # task, method, objectives, kind, activation
print(about["kind"], "policy for", about["task"], "by", about.get("method", "a method it does not say"))

# Four raw observations; the normaliser is inside. The batch may have any size.
length = session.get_inputs()[0].shape[1]
obs = np.random.default_rng(0).normal(size=(4, length)).astype(np.float32)

# The environment's own actions, never beyond its bounds. A stochastic policy also has "mean" and "std".
[action] = session.run(["action"], {"obs": obs})
print(np.round(action, 4))
