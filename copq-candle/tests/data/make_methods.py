"""Four updates of SAC, REDQ and every constrained method, and ten of COP-Q on TD3 with FAMO, in plain PyTorch, for
copq-candle's `methods` test to follow.

Written from the methods' equations (Haarnoja et al. 2018; Chen et al. 2021; Wu et al. 2024; Liu et al. 2023; the COP-Q
paper, sec. 4, 5 and App. A), in double precision and by autograd, without anything of copq but its random numbers: `methods_draws.json` holds
the first numbers of its streams (`cargo test -p copq-candle --test all -- --ignored` writes it).

Run once:  python make_methods.py  writes `methods.json` (COP-Q on TD3 with Debian's torch 1.13.1; the others have the same
nine digits with torch 2.5.1).
"""

import copy
import json
from pathlib import Path

import torch

HERE = Path(__file__).parent
OBSERVATION, ACTION, HIDDEN, TRANSITIONS, BATCH, UPDATES = 5, 2, 8, 12, 8, 4
LR, TAU, DISCOUNT, HORIZON, LIMIT = 3e-3, 0.05, 0.9, 50, -1.0
FAMO_LR, FAMO_DECAY = 0.025, 0.3  # a decay that shows within ten updates
TEMPERATURE, ENTROPY_LR, MULTIPLIER, MULTIPLIER_LR, AUGMENTATION = 0.5, 0.01, 0.8, 0.02, 10.0
DRAWS = json.loads((HERE / "methods_draws.json").read_text())
torch.set_default_dtype(torch.float64)


class Streams:
    """copq's random numbers in the order in which a learner takes them."""

    def __init__(self):
        self.batch, self.subset, self.normals = iter(DRAWS["batch"]), iter(DRAWS["subset"]), iter(DRAWS["normals"])

    def rows(self):
        return [(int(next(self.batch)) * TRANSITIONS) >> 64 for _ in range(BATCH)]

    def pair(self, critics):
        positions = list(range(critics))
        for i in range(2):
            j = i + ((int(next(self.subset)) * (critics - i)) >> 64)
            positions[i], positions[j] = positions[j], positions[i]
        return positions[:2]

    def noise(self):
        return torch.tensor([[next(self.normals) for _ in range(ACTION)] for _ in range(BATCH)])


def perceptron(inputs, outputs):
    network = torch.nn.Sequential(torch.nn.Linear(inputs, HIDDEN), torch.nn.ReLU(), torch.nn.Linear(HIDDEN, outputs))
    with torch.no_grad():  # numbers that single precision holds exactly
        for parameter in network.parameters():
            parameter.copy_(parameter.float())
    return network


def numbers(tensor):
    return tensor.detach().flatten().tolist()


def parameters(network):
    names = ["layer.0.weight", "layer.0.bias", "layer.1.weight", "layer.1.bias"]
    return {name: numbers(value) for name, value in zip(names, network.state_dict().values())}


def values(networks, obs, action):
    """networks x rows x outputs"""
    return torch.stack([network(torch.cat([obs, action], 1)) for network in networks])


def gaussian(actor, obs, noise):
    mean, log_std = actor(obs).chunk(2, 1)
    policy = torch.distributions.Normal(mean, log_std.clamp(-20, 2).exp())
    x = mean + policy.scale * noise
    correction = 2 * (torch.log(torch.tensor(2.0)) - x - torch.nn.functional.softplus(-2 * x))
    return torch.tanh(x), (policy.log_prob(x) - correction).sum(1)


def cholesky_bound(q, weights):
    """mean - L R u of critics x rows x objectives, with R the rotation matrix of the paper's A.2-A.4."""
    u = weights / weights.norm()
    mean = q.mean(0)
    deviations = q - mean
    covariance = torch.einsum("kbi,kbj->bij", deviations, deviations) / len(q)
    rows = []
    for row in range(q.shape[1]):
        low = torch.linalg.cholesky(covariance[row])
        p = low.T @ u
        a, rho = u @ p, p.norm()
        eye = torch.eye(len(u))
        rotation = eye
        if a < 0:
            v = (p - a * u) / (rho**2 - a**2).sqrt()
            k = torch.outer(v, u) - torch.outer(u, v)
            rotation = eye - (a / rho) * k + (1 - (1 - (a / rho) ** 2).sqrt()) * (k @ k)
        rows.append(mean[row] - low @ rotation @ u)
    return torch.stack(rows)


class Famo:
    """Weights of the objectives' losses from one logit each, with AdamW's decay or Adam's L2."""

    def __init__(self, objectives, l2):
        self.logits = torch.zeros(objectives, requires_grad=True)
        optimiser = torch.optim.Adam if l2 else torch.optim.AdamW
        self.adam = optimiser([self.logits], lr=FAMO_LR, weight_decay=FAMO_DECAY)

    def weigh(self, losses):
        weights = torch.softmax(self.logits, 0).detach() / (losses.detach() + 1e-8)
        return weights / weights.sum()

    def step(self, before, after):
        improvement = torch.log(before.detach() + 1e-8) - torch.log(after + 1e-8)
        softmax = torch.softmax(self.logits, 0)
        self.logits.grad = torch.autograd.grad(softmax, self.logits, grad_outputs=improvement)[0]
        self.adam.step()


class Method:
    """What tells the methods apart: critics, bounds, REDQ's draws, policy, the entropy bonus's reward, constraint, FAMO."""

    def __init__(self, name, networks, outputs, bound=None, redq=False, deterministic=False, bonus=-1, constraint=None, own_costs=False, famo=None):
        self.name, self.bound, self.redq, self.deterministic, self.constraint = name, bound, redq, deterministic, constraint
        self.own_costs, self.outputs, self.bonus, self.famo = own_costs, outputs, bonus, famo
        self.critics = torch.nn.ModuleList([perceptron(OBSERVATION + ACTION, outputs) for _ in range(networks)])
        self.actor = perceptron(OBSERVATION, ACTION if deterministic else 2 * ACTION)


def run(method, data, reward, updates=UPDATES):
    obs, action, next_obs, alive = data["obs"], data["action"], data["next_obs"], data["alive"]
    streams, critics, actor = Streams(), method.critics, method.actor
    start = {"critics": [parameters(c) for c in critics], "actor": parameters(actor)}
    targets, target_actor = copy.deepcopy(critics), copy.deepcopy(actor)
    critic_adam = torch.optim.Adam(critics.parameters(), lr=LR)
    actor_adam = torch.optim.Adam(actor.parameters(), lr=LR)
    log_alpha = torch.tensor(TEMPERATURE).log().requires_grad_()
    alpha_adam = torch.optim.Adam([log_alpha], lr=ENTROPY_LR)
    log_lambda = torch.tensor(MULTIPLIER).log().requires_grad_()
    lambda_adam = torch.optim.Adam([log_lambda], lr=MULTIPLIER_LR)
    limit = LIMIT * (1 - DISCOUNT**HORIZON) / ((1 - DISCOUNT) * HORIZON)
    effective, estimate = 0.0, 0.0
    for update in range(1, updates + 1):
        rows = streams.rows()
        s, a, s2, not_dead, r = obs[rows], action[rows], next_obs[rows], alive[rows], reward[rows]
        alpha, lam = log_alpha.exp().detach(), log_lambda.exp().detach()
        weights = torch.stack([-lam, torch.tensor(1.0)]) if method.constraint is not None else data["weights" if r.shape[1] < 3 else "three_weights"]
        if r.shape[1] == 1:
            weights = torch.ones(1)

        with torch.no_grad():
            if method.deterministic:
                smoothing = (0.2 * streams.noise()).clamp(-0.5, 0.5)
                a2, log_prob = (torch.tanh(target_actor(s2)) + smoothing).clamp(-1, 1), torch.zeros(BATCH)
            else:
                a2, log_prob = gaussian(actor, s2, streams.noise())
            if method.redq:
                q2 = values([targets[k] for k in streams.pair(len(targets))], s2, a2)
                promise = q2[(q2 @ weights).argmin(0), torch.arange(BATCH)]
            else:
                q2 = values(targets, s2, a2)
                promise = method.bound(q2, weights)
            promise[:, method.bonus] -= 0 if method.deterministic else alpha * log_prob
            y = r + DISCOUNT * not_dead[:, None] * promise

        q = values(critics, s, a)
        if method.outputs == 1 and r.shape[1] == 2:  # scalar critics: the costs', then two of the reward
            costs = q[:-2, :, 0]
            own = r[:, 0] + DISCOUNT * not_dead * q2[:-2, :, 0]
            cost_loss = ((costs - (own if method.own_costs else y[:, 0])) ** 2).mean()
            loss = cost_loss + ((q[-2:, :, 0] - y[:, 1]) ** 2).mean()
        else:
            losses = ((q - y) ** 2).mean((0, 1))
            loss = losses.sum() if method.famo is None else (method.famo.weigh(losses) * losses).sum()
        critic_adam.zero_grad()
        loss.backward()
        critic_adam.step()
        if method.famo is not None:
            with torch.no_grad():
                after = ((values(critics, s, a) - y) ** 2).mean((0, 1))
            method.famo.step(losses, after)

        if update % 2 == 0:
            if method.constraint is not None:
                estimate = method.bound(values(critics, s, a).detach(), weights)[:, 0].mean().item()
                rect = min(method.constraint * (limit - estimate), lam.item())
                effective = lam.item() - rect
                scale = torch.tensor([-effective, 1.0])
            else:
                scale = weights / weights.norm()
            policy = (torch.tanh(actor(s)), 0) if method.deterministic else gaussian(actor, s, streams.noise())
            best, log_prob = policy
            promise = values(critics, s, best)
            promise = promise.mean(0) if method.redq else method.bound(promise, weights)
            actor_loss = (alpha * scale[method.bonus] * log_prob - promise @ scale).mean()
            actor_adam.zero_grad()
            actor_loss.backward()
            actor_adam.step()
            if not method.deterministic:
                alpha_adam.zero_grad()
                (log_alpha.exp() * (-log_prob.detach() + ACTION).mean()).backward()
                alpha_adam.step()
            if method.constraint is not None:
                lambda_adam.zero_grad()
                (log_lambda.exp() * (limit - estimate)).backward()
                lambda_adam.step()

        if method.redq or method.famo is not None or update % 2 == 0:
            with torch.no_grad():
                pairs = [*zip(targets.parameters(), critics.parameters()), *zip(target_actor.parameters(), actor.parameters())]
                for target, online in pairs:
                    target.copy_((1 - TAU) * target + TAU * online)

    return {
        "name": method.name, "start": start, "updates": updates,
        "end": {
            "critics": [parameters(c) for c in critics], "targets": [parameters(c) for c in targets],
            "actor": parameters(actor), "log_alpha": log_alpha.item(), "log_lambda": log_lambda.item(),
            "effective": effective, "estimate": estimate,
            "famo": numbers(method.famo.logits) if method.famo is not None else None,
        },
    }


def pairwise(q, _):
    """SACLag-UCB: the larger of two cost critics, the smaller of two reward critics."""
    return torch.stack([q[:2, :, 0].max(0).values, q[2:, :, 0].min(0).values], 1)


def cal(q, _):
    """CAL: mean + 0.5 standard deviations (over E - 1) of four cost critics, the smaller of two reward critics."""
    costs = q[:4, :, 0]
    return torch.stack([costs.mean(0) + 0.5 * costs.std(0), q[4:, :, 0].min(0).values], 1)


torch.manual_seed(15)
single = lambda *shape: torch.randn(*shape).float().double()
data = {
    "obs": single(TRANSITIONS, OBSERVATION), "next_obs": single(TRANSITIONS, OBSERVATION),
    "action": torch.tanh(single(TRANSITIONS, ACTION)).float().double(), "alive": (torch.rand(TRANSITIONS) > 0.3).double(),
    "reward": single(TRANSITIONS, 2), "weights": torch.tensor([1.0, 2.0]),
}
methods = [
    run(Method("sac", 2, 1, lambda q, _: q.min(0).values), data, data["reward"][:, 1:]),
    run(Method("redq", 5, 2, redq=True, deterministic=True), data, data["reward"]),
    run(Method("saclag-ucb", 4, 1, pairwise, constraint=0.0), data, data["reward"]),
    run(Method("cal", 6, 1, cal, constraint=AUGMENTATION, own_costs=True), data, data["reward"]),
    run(Method("cop-q on cal", 3, 2, cholesky_bound, constraint=AUGMENTATION), data, data["reward"]),
    # REDQ on SAC; the first of two rewards, which have unequal weights, has the entropy bonus.
    run(Method("redq on sac", 5, 2, redq=True, bonus=0), data, data["reward"]),
]
data["three_rewards"], data["three_weights"] = single(TRANSITIONS, 3), torch.tensor([1.0, 2.0, 0.5])
for name, l2 in [("cop-q on td3", False), ("cop-q on td3, l2", True)]:
    method = Method(name, 4, 3, cholesky_bound, deterministic=True, famo=Famo(3, l2))
    with torch.no_grad():
        for critic in method.critics:  # the second objective against the first, so that the clip fires
            for parameter in (critic[2].weight, critic[2].bias):
                parameter[1] = (0.5 * parameter[1] - 1.5 * parameter[0]).float()
    methods.append(run(method, data, data["three_rewards"], 10))
settings = {
    "torch": torch.__version__, "observation": OBSERVATION, "action": ACTION, "hidden": HIDDEN, "batch": BATCH,
    "updates": UPDATES, "lr": LR, "tau": TAU, "discount": DISCOUNT, "horizon": HORIZON, "limit": LIMIT,
    "temperature": TEMPERATURE, "entropy_lr": ENTROPY_LR, "multiplier": MULTIPLIER, "multiplier_lr": MULTIPLIER_LR,
    "famo_lr": FAMO_LR, "famo_decay": FAMO_DECAY,
    "augmentation": AUGMENTATION, "data": {name: numbers(value) for name, value in data.items()}, "methods": methods,
}
rounded = json.loads(json.dumps(settings), parse_float=lambda text: float(f"{float(text):.9g}"))
(HERE / "methods.json").write_text(json.dumps(rounded))
