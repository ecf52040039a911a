"""One COP-TD3 update in JAX, compiled as a whole: one update per call, or a scan over many.

    python jax_update.py FOLDER ACTOR_DELAY THREADS

answers bench/run.py for `step` and `scan`; FOLDER is what `update --write` wrote.
"""

import os
import sys
from functools import partial

if sys.argv[3] == "1":
    # Before JAX starts its threads.
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import jax
import jax.numpy as jnp
import numpy as np
from shared import DISCOUNT, LR, TAU, Workload, serve

tree_map = jax.tree_util.tree_map


def mlp(layers, x):
    for weight, bias in layers[:-1]:
        x = jax.nn.relu(x @ weight + bias)
    weight, bias = layers[-1]
    return x @ weight + bias


def values(critics, obs, action):
    """Critics x rows x objectives."""
    both = jnp.concatenate([obs, action], 1)
    return jnp.stack([mlp(critic, both) for critic in critics])


def lower_bound(q):
    """COP-Q's bound with its clip for equal weights: Gram-Schmidt on the critics' deviations, column by column."""
    mean = q.mean(0)
    x = [q[:, :, i] - mean[:, i] for i in range(q.shape[2])]
    u = len(x) ** -0.5
    e, factor = [], []
    for column in x:
        row = [(column * other).mean(0) for other in e]
        rest = column
        for other, l in zip(e, row):
            rest = rest - other * l
        pivot = jnp.sqrt((rest * rest).mean(0))
        e.append(rest / pivot)
        factor.append([*row, pivot])
    p = [sum(row[j] for row in factor[j:]) * u for j in range(len(x))]
    along = jnp.minimum(sum(p) * u, 0)
    scale = along / sum(x * x for x in p)
    turned = [u - scale * x for x in p]
    length = jnp.sqrt(sum(x * x for x in turned))
    offset = [sum(l * t for l, t in zip(row, turned)) / length for row in factor]
    return mean - jnp.stack(offset, 1)


def adam(parameters, grads, state):
    """PyTorch's Adam."""
    count, m, v = state
    count = count + 1
    m = tree_map(lambda m, g: 0.9 * m + 0.1 * g, m, grads)
    v = tree_map(lambda v, g: 0.999 * v + 0.001 * g * g, v, grads)
    rate, scale = LR / (1 - 0.9**count), 1 / jnp.sqrt(1 - 0.999**count)
    step = lambda x, m, v: x - rate * m / (jnp.sqrt(v) * scale + 1e-8)
    return tree_map(step, parameters, m, v), (count, m, v)


def critic_losses(critics, target, batch):
    losses = jnp.square(values(critics, batch["obs"], batch["action"]) - target).mean((0, 1))
    return losses.sum(), losses


def actor_loss(actor, critics, batch):
    action = jnp.tanh(mlp(actor, batch["obs"]))
    return -lower_bound(values(critics, batch["obs"], action)).sum(1).mean()


def update(moves_actor, state, batch):
    """The new state and the losses."""
    online, target, (critic_adam, actor_adam) = state
    (critics, actor), (target_critics, target_actor) = online, target
    next_action = jnp.clip(jnp.tanh(mlp(target_actor, batch["next_obs"])) + batch["noise"], -1, 1)
    bound = lower_bound(values(target_critics, batch["next_obs"], next_action))
    y = batch["reward"] + DISCOUNT * batch["alive"] * bound
    grads, losses = jax.grad(critic_losses, has_aux=True)(critics, y, batch)
    critics, critic_adam = adam(critics, grads, critic_adam)
    if moves_actor:
        loss, grads = jax.value_and_grad(actor_loss)(actor, critics, batch)
        actor, actor_adam = adam(actor, grads, actor_adam)
        losses = jnp.append(losses, loss)
    online = (critics, actor)
    target = tree_map(lambda target, online: (1 - TAU) * target + TAU * online, target, online)
    return (online, target, (critic_adam, actor_adam)), losses


def updates_to_actor(state, batches):
    """One update for each batch; the last one also moves the actor."""
    state, losses = jax.lax.scan(partial(update, False), state, tree_map(lambda x: x[:-1], batches))
    state, last = update(True, state, tree_map(lambda x: x[-1], batches))
    return state, jnp.append(losses, last)


class Program:
    def __init__(self, workload):
        self.delay = workload.actor_delay
        self.batches = [tree_map(jnp.asarray, batch) for batch in workload.batches]
        layers = lambda network: [(jnp.asarray(weight.T), jnp.asarray(bias)) for weight, bias in network]
        critics, actor = [layers(critic) for critic in workload.critics], layers(workload.actor)
        fresh = lambda x: (jnp.float32(0), tree_map(jnp.zeros_like, x), tree_map(jnp.zeros_like, x))
        online = (critics, actor)
        self.state = (online, tree_map(jnp.copy, online), (fresh(critics), fresh(actor)))
        self.done = 0

    def wait(self, losses):
        jax.block_until_ready((self.state, losses))

    def flat(self, losses):
        return np.concatenate([np.ravel(loss) for loss in losses]).tolist()


class Step(Program):
    def __init__(self, workload):
        super().__init__(workload)
        self.update = jax.jit(update, static_argnums=0, donate_argnums=1)

    def run(self, updates):
        all_losses = []
        for _ in range(updates):
            batch = self.batches[self.done % len(self.batches)]
            self.done += 1
            self.state, losses = self.update(self.done % self.delay == 0, self.state, batch)
            all_losses.append(losses)
        return all_losses


class Scan(Program):
    def __init__(self, workload):
        super().__init__(workload)
        self.many = jax.jit(partial(jax.lax.scan, updates_to_actor), donate_argnums=0)
        self.stacks = {}

    def run(self, updates):
        first = self.done % len(self.batches)
        if (first, updates) not in self.stacks:
            self.stacks[first, updates] = self.stack(first, updates)
        self.done += updates
        self.state, losses = self.many(self.state, self.stacks[first, updates])
        return [losses]

    def stack(self, first, updates):
        """Batches as calls of `updates_to_actor` x updates in each x rows x ..."""
        chosen = [self.batches[(first + i) % len(self.batches)] for i in range(updates)]
        shape = lambda x: x.reshape(-1, self.delay, *x.shape[1:])
        return tree_map(lambda *x: shape(jnp.stack(x)), *chosen)


def main():
    workload = Workload(sys.argv[1], int(sys.argv[2]))
    serve({"step": partial(Step, workload), "scan": partial(Scan, workload)})


if __name__ == "__main__":
    main()
