"""Whole environment steps of training TD3 on Gymnasium's hopper by Stable-Baselines3 or by SBX.

    python td3_steps.py THREADS

answers bench/run.py for `sb3` and `sbx`: `time NAME STEPS` with a step's milliseconds, on the wall and on the processors.
"""

import os
import sys
from functools import partial

if sys.argv[1] == "1":
    # Before JAX starts its threads.
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import gymnasium
import numpy as np
import sbx
import stable_baselines3
import torch
from shared import serve
from stable_baselines3.common.noise import NormalActionNoise

START = 1000


class Training:
    def __init__(self, library):
        env = gymnasium.make("Hopper-v5")
        noise = NormalActionNoise(np.zeros(3), np.full(3, 0.1))
        self.model = library.TD3(
            "MlpPolicy",
            env,
            learning_rate=3e-4,
            learning_starts=START,
            batch_size=256,
            train_freq=1,
            gradient_steps=1,
            action_noise=noise,
            policy_kwargs={"net_arch": [256, 256]},
            seed=0,
            device="cpu",
        )
        self.model.learn(START)

    def run(self, steps):
        # No progress bar, no logger's table.
        self.model.learn(steps, reset_num_timesteps=False, log_interval=None)

    def wait(self, _):
        pass


def main():
    torch.set_num_threads(int(sys.argv[1]))
    serve({"sb3": partial(Training, stable_baselines3), "sbx": partial(Training, sbx)})


if __name__ == "__main__":
    main()
