"""Whole environment steps of training CPPOPID on Gymnasium's hopper by OmniSafe.

    python omnisafe_steps.py THREADS

answers bench/run.py for `omnisafe`: `time omnisafe STEPS` with a step's milliseconds, as wall time and as CPU time.
STEPS must be a whole number of epochs. Needs Python 3.10 and requirements-omnisafe.txt.

OmniSafe's own `learn` is timed over that many epochs: rollout, multiplier, update, and its logger with one row of CSV
per epoch. Progress bars, TensorBoard and the saving of weights are off, and its output is discarded. Settings that are
not given here are OmniSafe's defaults: 40 passes over minibatches of 64, 64-64, tanh, 3e-4, and so on.
"""

import os
import sys
import tempfile
from contextlib import redirect_stdout
from functools import partial

import gymnasium
import rich.progress
import torch
from shared import serve

# No progress bars. OmniSafe must be imported after this.
rich.progress.track = lambda sequence, **_: sequence

# Standard output is only for answers.
NOWHERE = open(os.devnull, "w")
with redirect_stdout(NOWHERE):
    import omnisafe
    from omnisafe.envs.core import env_register
    from omnisafe.envs.mujoco_env import MujocoEnv

EPOCH = 2048
TASK = "HopperSpeed-v4"
gymnasium.register(TASK, entry_point="gymnasium.envs.mujoco.hopper_v4:HopperEnv", max_episode_steps=1000)


@env_register
class Hopper(MujocoEnv):
    """Gymnasium's hopper, with its speed as the cost."""

    _support_envs = [TASK]

    def step(self, action):
        obs, reward, _, terminated, truncated, info = super().step(action.clamp(-1, 1))
        return obs, reward, torch.tensor(abs(info["x_velocity"]), dtype=torch.float32), terminated, truncated, info


class Training:
    def __init__(self, threads):
        self.folder = tempfile.TemporaryDirectory()
        settings = {
            "train_cfgs": {"total_steps": EPOCH, "vector_env_nums": 1, "torch_threads": threads},
            "algo_cfgs": {"steps_per_epoch": EPOCH, "kl_early_stop": False},
            "model_cfgs": {"linear_lr_decay": False},
            "logger_cfgs": {"log_dir": self.folder.name, "use_tensorboard": False},
        }
        with redirect_stdout(NOWHERE):
            self.learner = omnisafe.Agent("CPPOPID", TASK, custom_cfgs=settings).agent
        # `learn` is called repeatedly, so it must not save or close anything.
        self.learner._logger.torch_save = self.learner._logger.close = self.learner._env.close = lambda: None
        self.run(EPOCH)

    def run(self, steps):
        self.learner._cfgs.train_cfgs.epochs = steps // EPOCH
        with redirect_stdout(NOWHERE):
            self.learner.learn()

    def wait(self, _):
        pass


def main():
    serve({"omnisafe": partial(Training, int(sys.argv[1]))})


if __name__ == "__main__":
    main()
