"""Whole environment steps of training PPO on Gymnasium's hopper by Stable-Baselines3 or by SBX.

    python ppo_steps.py THREADS

answers bench/run.py for `sb3` and `sbx`: `time NAME STEPS` with a step's milliseconds, on the wall and on the processors.
STEPS must be whole epochs. Networks are what both have by default: 64-64, tanh, separate for actor and critic.
"""

import os
import sys
from functools import partial

if sys.argv[1] == "1":
    # Before JAX starts its threads.
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import sbx
import stable_baselines3
import torch
from shared import serve
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

EPOCH = 2048


class Training:
    def __init__(self, library):
        env = VecNormalize(make_vec_env("Hopper-v5"), norm_reward=False, clip_obs=5)
        self.model = library.PPO(
            "MlpPolicy",
            env,
            learning_rate=3e-4,
            n_steps=EPOCH,
            batch_size=64,
            n_epochs=40,
            gamma=0.99,
            gae_lambda=0.95,
            clip_range=0.2,
            ent_coef=0,
            max_grad_norm=40,
            normalize_advantage=True,
            target_kl=None,
            policy_kwargs={"net_arch": {"pi": [64, 64], "vf": [64, 64]}},
            seed=0,
            device="cpu",
        )
        self.run(EPOCH)

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
