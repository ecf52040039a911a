"""Plays actions in Python itself: package, id, arguments as JSON, file of actions (f32); writes every number that it sees as f32."""

import importlib
import json
import sys

import numpy as np

package, name, arguments, actions = sys.argv[1:]
env = importlib.import_module(package).make(name, **json.loads(arguments))
shape = env.action_space.shape
episode = 0


def write(*values):
    for value in values:
        sys.stdout.buffer.write(np.asarray(value, dtype="<f4").tobytes())


write(env.reset(seed=episode)[0])
for action in np.fromfile(actions, "<f4").reshape(-1, *shape):
    obs, reward, *cost, terminated, truncated, _ = env.step(action.astype(env.action_space.dtype))
    write(obs, *cost, reward)
    if terminated or truncated:
        episode += 1
        write(env.reset(seed=episode)[0])
