"""PPO's update in plain PyTorch, for tests/all/on_policy.rs: python3 make_on_policy.py (needs torch; no other library).

Networks, observations and actions are those of on_policy/ppo.json. Rows come in minibatches of 24, the last one smaller, in
orders that are stored with the networks that come of it.
"""

import json
from pathlib import Path

import torch
from torch import nn

HERE = Path(__file__).parent / "on_policy"
PASSES, BATCH, CLIP, ENTROPY, PENALTY, NORM, LR, LAMBDA = 3, 24, 0.2, 0.01, 0.001, 0.5, 1e-3, 0.6


def network(stored):
    layers = []
    for layer in stored["layers"]:
        weight = torch.tensor(layer["weight"])
        linear = nn.Linear(weight.shape[1], weight.shape[0])
        with torch.no_grad():
            linear.weight.copy_(weight)
            linear.bias.copy_(torch.tensor(layer["bias"]))
        layers += [linear, nn.Tanh()]
    return nn.Sequential(*layers[:-1])


def layers(net):
    linears = [layer for layer in net if isinstance(layer, nn.Linear)]
    return {"layers": [{"weight": l.weight.tolist(), "bias": l.bias.tolist()} for l in linears]}


def main():
    torch.manual_seed(5)
    reference = json.loads((HERE / "ppo.json").read_text())
    batch = {name: torch.tensor(values) for name, values in reference["batch"].items()}
    stored = reference["networks"]
    actor = network(stored["actor"])
    log_std = nn.Parameter(torch.tensor(stored["actor"]["log_std"]))
    critics = {name: network(stored[name]) for name in ("reward_critic", "cost_critic")}
    targets = {"reward_critic": batch["target_value_r"], "cost_critic": batch["target_value_c"]}
    policy = [*actor.parameters(), log_std]
    optimisers = {name: torch.optim.Adam(net.parameters(), LR) for name, net in critics.items()}
    optimiser = torch.optim.Adam(policy, LR)
    law = lambda obs: torch.distributions.Normal(actor(obs), log_std.exp())
    with torch.no_grad():
        before = law(batch["obs"])
        log_prob = before.log_prob(batch["act"]).sum(1)
    advantage = (batch["adv_r"] - LAMBDA * batch["adv_c"]) / (1 + LAMBDA)
    orders, divergences = [], []
    for _ in range(PASSES):
        order = torch.randperm(len(advantage))
        orders.append(order.tolist())
        for rows in order.split(BATCH):
            obs = batch["obs"][rows]
            for name, net in critics.items():
                loss = (net(obs).squeeze(1) - targets[name][rows]).square().mean()
                loss = loss + PENALTY * sum(p.square().sum() for p in net.parameters())
                optimisers[name].zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(net.parameters(), NORM)
                optimisers[name].step()
            now = law(obs)
            ratio = (now.log_prob(batch["act"][rows]).sum(1) - log_prob[rows]).exp()
            cut = ratio.clamp(1 - CLIP, 1 + CLIP)
            gain = torch.minimum(ratio * advantage[rows], cut * advantage[rows]).mean()
            loss = -gain - ENTROPY * now.entropy().mean()
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(policy, NORM)
            optimiser.step()
        with torch.no_grad():
            kl = torch.distributions.kl_divergence(before, law(batch["obs"])).sum(1).mean()
        divergences.append(kl.item())
    out = {
        "about": "an update of PPO in plain PyTorch (make_on_policy.py), float32 on the CPU",
        "made_by": f"PyTorch {torch.__version__.split('+')[0]}",
        "settings": {
            "passes": PASSES,
            "batch": BATCH,
            "clip": CLIP,
            "entropy": ENTROPY,
            "critic_decay": PENALTY,
            "max_norm": NORM,
            "lr": LR,
            "lambda": LAMBDA,
        },
        "log_prob": log_prob.tolist(),
        "orders": orders,
        "kl": divergences,
        "after": {
            "actor": {**layers(actor), "log_std": log_std.tolist()},
            **{name: layers(net) for name, net in critics.items()},
        },
    }
    (HERE / "torch.json").write_text(json.dumps(out) + "\n")


if __name__ == "__main__":
    main()
