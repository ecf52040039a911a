"""Whole environment steps of training TD3 or PPO on Gymnasium's hopper by Stable-Baselines3 or by SBX.

    python sb3_steps.py td3|ppo THREADS

answers bench/run.py for `sb3` and `sbx`: `time NAME STEPS` with a step's milliseconds, as wall time and as CPU time.
PPO's STEPS must be a whole number of epochs. Its networks are the default of both: 64-64, tanh, separate for actor and
critic.
"""

import os
import sys
from functools import partial

if sys.argv[2] == "1":
    # Before JAX starts its threads.
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import gymnasium
import numpy as np
import sbx
import stable_baselines3
import torch
from shared import serve
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.noise import NormalActionNoise
from stable_baselines3.common.vec_env import VecNormalize

START = 1000
EPOCH = 2048


def td3(library):
    """A learner, and how many steps it runs before anything is timed."""
    model = library.TD3(
        "MlpPolicy",
        gymnasium.make("Hopper-v5"),
        learning_rate=3e-4,
        learning_starts=START,
        batch_size=256,
        train_freq=1,
        gradient_steps=1,
        action_noise=NormalActionNoise(np.zeros(3), np.full(3, 0.1)),
        policy_kwargs={"net_arch": [256, 256]},
        seed=0,
        device="cpu",
    )
    return model, START


def ppo(library):
    model = library.PPO(
        "MlpPolicy",
        VecNormalize(make_vec_env("Hopper-v5"), norm_reward=False, clip_obs=5),
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
    return model, EPOCH


class Training:
    def __init__(self, method, library):
        self.model, start = method(library)
        self.run(start)

    def run(self, steps):
        # Without a progress bar or the logger's table.
        self.model.learn(steps, reset_num_timesteps=False, log_interval=None)

    def wait(self, _):
        pass


def main():
    torch.set_num_threads(int(sys.argv[2]))
    training = partial(Training, {"td3": td3, "ppo": ppo}[sys.argv[1]])
    serve({"sb3": partial(training, stable_baselines3), "sbx": partial(training, sbx)})


if __name__ == "__main__":
    main()
