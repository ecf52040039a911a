"""Ten TD3-like updates in plain PyTorch, written down for copq-candle's `pytorch` test to follow.

Run once, with torch 2.5.1 and safetensors 0.8:  python make_reference.py
It writes `reference_critics.safetensors` and `reference_actor.safetensors` (the initial weights) and `reference.json`
(settings, batches, and what PyTorch made of them: losses, Q-values, actions).
"""

import copy
import json
from pathlib import Path

import torch
from safetensors.torch import save_file

HERE = Path(__file__).parent
OBSERVATION, ACTION, OBJECTIVES, CRITICS, HIDDEN, BATCH, UPDATES = 11, 3, 3, 4, 16, 8, 10
CRITIC_LR, ACTOR_LR, TAU, DISCOUNT = 1e-3, 5e-4, 0.05, 0.99
LOSS_WEIGHTS = torch.tensor([0.5, 1.0, 2.0])  # one an objective, as FAMO would give
DIRECTION = torch.tensor([0.6, 0.64, 0.48])  # the actor maximises this combination of the objectives


def perceptron(inputs, outputs):
    relu = torch.nn.ReLU
    return torch.nn.Sequential(
        torch.nn.Linear(inputs, HIDDEN), relu(), torch.nn.Linear(HIDDEN, HIDDEN), relu(), torch.nn.Linear(HIDDEN, outputs)
    )


def act(network, obs):
    return torch.tanh(network(obs))


def values(networks, obs, action):
    """critics x rows x objectives"""
    return torch.stack([network(torch.cat([obs, action], 1)) for network in networks])


def track(targets, networks):
    with torch.no_grad():
        for target, online in zip(targets.parameters(), networks.parameters()):
            target.copy_((1 - TAU) * target + TAU * online)


def named(network, prefix):
    """Our names: layer.0, layer.1, ... where Sequential counts the ReLUs too."""
    arrays = {}
    for name, tensor in network.state_dict().items():
        position, kind = name.split(".")
        arrays[f"{prefix}.layer.{int(position) // 2}.{kind}"] = tensor.clone()
    return arrays


def numbers(tensor):
    return tensor.detach().flatten().tolist()


torch.manual_seed(1)
critics = torch.nn.ModuleList([perceptron(OBSERVATION + ACTION, OBJECTIVES) for _ in range(CRITICS)])
actor = perceptron(OBSERVATION, ACTION)
save_file({k: v for i, c in enumerate(critics) for k, v in named(c, f"critic.{i}").items()}, HERE / "reference_critics.safetensors")
save_file(named(actor, "actor"), HERE / "reference_actor.safetensors")

target_critics, target_actor = copy.deepcopy(critics), copy.deepcopy(actor)
critic_adam = torch.optim.Adam(critics.parameters(), lr=CRITIC_LR)
actor_adam = torch.optim.Adam(actor.parameters(), lr=ACTOR_LR)

updates = []
for update in range(1, UPDATES + 1):
    obs, next_obs = torch.randn(BATCH, OBSERVATION), torch.randn(BATCH, OBSERVATION)
    action, reward = torch.rand(BATCH, ACTION) * 2 - 1, torch.randn(BATCH, OBJECTIVES)

    with torch.no_grad():
        next_action = act(target_actor, next_obs)
        y = reward + DISCOUNT * values(target_critics, next_obs, next_action).mean(0)
    q = values(critics, obs, action)
    losses = ((q - y) ** 2).mean((0, 1))
    critic_adam.zero_grad()
    (LOSS_WEIGHTS * losses).sum().backward()
    critic_adam.step()

    actor_loss = None
    if update % 2 == 0:
        objective = (values(critics, obs, act(actor, obs)).mean(0) * DIRECTION).sum(1).mean()
        actor_adam.zero_grad()
        (-objective).backward()
        actor_adam.step()
        actor_loss = -objective.item()

    track(target_critics, critics)
    track(target_actor, actor)
    updates.append({
        "obs": numbers(obs), "action": numbers(action), "reward": numbers(reward), "next_obs": numbers(next_obs),
        "target": numbers(y), "q": numbers(q), "losses": numbers(losses), "actor_loss": actor_loss,
        "q_after": numbers(values(critics, obs, action)), "policy_after": numbers(act(actor, obs)),
        "target_policy_after": numbers(act(target_actor, obs)),
    })

settings = {
    "torch": torch.__version__, "observation": OBSERVATION, "action": ACTION, "objectives": OBJECTIVES, "critics": CRITICS,
    "hidden": HIDDEN, "critic_lr": CRITIC_LR, "actor_lr": ACTOR_LR, "tau": TAU, "discount": DISCOUNT,
    "loss_weights": numbers(LOSS_WEIGHTS), "direction": numbers(DIRECTION), "updates": updates,
}
rounded = json.loads(json.dumps(settings), parse_float=lambda text: float(f"{float(text):.9g}"))
(HERE / "reference.json").write_text(json.dumps(rounded))
