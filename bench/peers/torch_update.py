"""One COP-TD3 update in PyTorch: separate critics and fused Adam, eager or compiled.

    python torch_update.py FOLDER ACTOR_DELAY THREADS

answers bench/run.py for `eager` and `compiled`; FOLDER is what `update --write` wrote.
"""

import sys
from functools import partial

import torch
from shared import DISCOUNT, LR, TAU, Workload, serve
from torch import nn


def mlp(layers):
    modules = []
    for weight, bias in layers:
        linear = nn.Linear(weight.shape[1], weight.shape[0])
        linear.load_state_dict({"weight": torch.from_numpy(weight), "bias": torch.from_numpy(bias)})
        modules += [linear, nn.ReLU()]
    return nn.Sequential(*modules[:-1])


def values(critics, obs, action):
    """Critics x rows x objectives."""
    both = torch.cat([obs, action], 1)
    return torch.stack([critic(both) for critic in critics])


def lower_bound(q):
    """COP-Q's bound with its clip for equal weights: Gram-Schmidt on the critics' deviations, column by column."""
    mean = q.mean(0)
    x = (q - mean).unbind(2)
    u = len(x) ** -0.5
    e, factor = [], []
    for column in x:
        row = [(column * other).mean(0) for other in e]
        rest = column
        for other, l in zip(e, row):
            rest = rest - other * l
        pivot = rest.square().mean(0).sqrt()
        e.append(rest / pivot)
        factor.append([*row, pivot])
    p = torch.stack([sum(row[j] for row in factor[j:]) * u for j in range(len(x))], 1)
    along = (p.sum(1, keepdim=True) * u).clamp(max=0)
    turned = u - along / p.square().sum(1, keepdim=True) * p
    turned = (turned / turned.norm(dim=1, keepdim=True)).unbind(1)
    offset = [sum(l * t for l, t in zip(row, turned)) for row in factor]
    return mean - torch.stack(offset, 1)


class Update:
    def __init__(self, workload, compiled):
        self.batches = [{name: torch.from_numpy(x) for name, x in batch.items()} for batch in workload.batches]
        self.critics, self.target_critics = (nn.ModuleList(map(mlp, workload.critics)) for _ in range(2))
        self.actor, self.target_actor = (mlp(workload.actor) for _ in range(2))
        self.critic_optimiser = torch.optim.Adam(self.critics.parameters(), lr=LR, fused=True)
        self.actor_optimiser = torch.optim.Adam(self.actor.parameters(), lr=LR, fused=True)
        self.online = [*self.critics.parameters(), *self.actor.parameters()]
        self.targets = [*self.target_critics.parameters(), *self.target_actor.parameters()]
        self.actor_parameters = list(self.actor.parameters())
        self.actor_delay = workload.actor_delay
        self.done = 0
        if compiled:
            self.critic_losses = torch.compile(self.critic_losses)
            self.actor_loss = torch.compile(self.actor_loss)

    def critic_losses(self, batch):
        with torch.no_grad():
            next_action = (self.target_actor(batch["next_obs"]).tanh() + batch["noise"]).clamp(-1, 1)
            bound = lower_bound(values(self.target_critics, batch["next_obs"], next_action))
            target = batch["reward"] + DISCOUNT * batch["alive"] * bound
        return (values(self.critics, batch["obs"], batch["action"]) - target).square().mean((0, 1))

    def actor_loss(self, batch):
        action = self.actor(batch["obs"]).tanh()
        return -lower_bound(values(self.critics, batch["obs"], action)).sum(1).mean()

    def update(self, batch):
        losses = self.critic_losses(batch)
        self.critic_optimiser.zero_grad()
        losses.sum().backward()
        self.critic_optimiser.step()
        reported = [losses.detach()]
        self.done += 1
        if self.done % self.actor_delay == 0:
            loss = self.actor_loss(batch)
            self.actor_optimiser.zero_grad()
            # Only these: the critics need no gradient here.
            loss.backward(inputs=self.actor_parameters)
            self.actor_optimiser.step()
            reported.append(loss.detach().reshape(1))
        with torch.no_grad():
            torch._foreach_lerp_(self.targets, self.online, TAU)
        return reported

    def run(self, updates):
        return [loss for _ in range(updates) for loss in self.update(self.batches[self.done % len(self.batches)])]

    def wait(self, losses):
        pass

    def flat(self, losses):
        return torch.cat(losses).tolist()


def main():
    folder, actor_delay, threads = sys.argv[1:]
    torch.set_num_threads(int(threads))
    workload = Workload(folder, int(actor_delay))
    serve({"eager": partial(Update, workload, compiled=False), "compiled": partial(Update, workload, compiled=True)})


if __name__ == "__main__":
    main()
