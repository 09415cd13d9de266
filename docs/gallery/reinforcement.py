# %% [markdown]
# # An environment for reinforcement learning
#
# A scenario is an environment of Gymnasium: machine, sensors, delay and noise stay, and an agent gives the
# commands in place of the law. Hundreds of episodes go side by side. Here the agent is a row of weights,
# with a sum of the error as its memory, and a search with 24 candidates of 8 episodes each moves them, for
# as long as one would wait.

# %%
import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from cmaes import CMA

import hydroservo.gym  # noqa: F401

changes = {"simulation.duration": "1 s", "controller.saturation.limit": "0.25 V"}
task = {"scenario": "rig/1khz-pi-sine", "changes": changes}
candidates, episodes = 24, 8
envs = gymnasium.make_vec("hydroservo/Velocity-v0", candidates * episodes, "vector_entry_point", **task)
signals, scales = envs.unwrapped.task.signals, envs.unwrapped.task.scales
velocity, demand = signals.index("controller.measured.velocity"), signals.index("reference.value")


# %%
def played(weights, seed):
    """The mean return of each row of weights over the same episodes, and what the first one saw."""
    seen, _ = envs.reset(seed=[seed + i for i in range(episodes)] * candidates)
    each = np.repeat(weights, episodes, axis=0)
    memory, total, first = np.zeros(len(each)), np.zeros(len(each)), []
    going = np.ones(len(each), dtype=bool)
    while going.any():
        memory += 0.02 * (seen[:, demand] - seen[:, velocity])
        actions = np.sum(each[:, :-1] * seen, axis=1) + each[:, -1] * memory
        seen, rewards, ended, cut, _ = envs.step(np.clip(actions, -1.0, 1.0)[:, np.newaxis])
        total += going * rewards
        going &= ~(ended | cut)
        first.append(seen[0, [demand, velocity]])
    return total.reshape(candidates, episodes).mean(axis=1), 1e3 * scales[demand] * np.array(first)


search = CMA(mean=np.zeros(len(signals) + 1), sigma=0.3, seed=1, population_size=candidates)
best = []
for generation in range(10):
    weights = np.array([search.ask() for _ in range(candidates)])
    returns, _ = played(weights, seed=1000 * generation)
    search.tell([(row, -value) for row, value in zip(weights, returns, strict=True)])
    best.append(returns.max())
_, trace = played(np.tile(search.mean, (candidates, 1)), seed=10**6)  # episodes that it has not met

# %%
picture, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.0), layout="constrained")
left.plot(best)
left.set(xlabel="generation", ylabel="return of the best")
right.plot(trace[:, 1], label="velocity")
right.plot(trace[:, 0], "k--", label="demand", linewidth=0.9)
right.set(xlabel="sample", ylabel="velocity [mm/s]")
right.legend()
picture.savefig("reinforcement.png")
