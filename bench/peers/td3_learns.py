"""What Stable-Baselines3's TD3 learns on Gymnasium's hopper with the settings of experiments/anchor.toml.

    python td3_learns.py SEED STEPS FILE

writes a line for every 5,000 steps: the mean return of ten episodes without noise, and their standard deviation.
"""

import csv
import sys

import gymnasium
import numpy as np
import torch
from stable_baselines3 import TD3
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.noise import NormalActionNoise

EVERY = 5000


class Evaluations(BaseCallback):
    def __init__(self, file, seed):
        super().__init__()
        self.file = file
        self.lines = csv.writer(file)
        self.lines.writerow(["step", "return/mean", "return/std"])
        self.env = gymnasium.make("Hopper-v5")
        self.env.reset(seed=1000 + seed)

    def _on_step(self):
        if self.num_timesteps % EVERY == 0:
            mean, std = evaluate_policy(self.model, self.env, n_eval_episodes=10, warn=False)
            self.lines.writerow([self.num_timesteps, mean, std])
            self.file.flush()
        return True


def main():
    seed, steps, path = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    torch.set_num_threads(1)
    model = TD3(
        "MlpPolicy",
        gymnasium.make("Hopper-v5"),
        learning_rate=3e-4,
        learning_starts=1000,
        batch_size=256,
        train_freq=1,
        gradient_steps=1,
        action_noise=NormalActionNoise(np.zeros(3), np.full(3, 0.1)),
        policy_kwargs={"net_arch": [256, 256]},
        seed=seed,
        device="cpu",
    )
    with open(path, "w", newline="") as file:
        model.learn(steps, callback=Evaluations(file, seed), log_interval=None)


if __name__ == "__main__":
    main()
