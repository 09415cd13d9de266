"""A linear policy with memory for the velocity of the rig, searched with CMA-ES, runs side by side."""

import gymnasium
import numpy as np
from cmaes import CMA

import hydroservo.gym

gymnasium.register_envs(hydroservo.gym)
CHANGES = {"simulation.duration": "1 s", "controller.saturation.limit": "0.25 V"}
TASK = {"scenario": "rig/1khz-pi-sine", "changes": CHANGES}
CANDIDATES, EPISODES, GENERATIONS = 32, 16, 40
MEMORY = 0.02  # of the summed error, a sample


def returns(envs: gymnasium.vector.VectorEnv, policies: np.ndarray, seed: int) -> np.ndarray:
    """The mean return of each policy, shape (policies, weights), over the same episodes."""
    seeds = [seed + i for i in range(EPISODES)] * len(policies)
    weights = np.repeat(policies, EPISODES, axis=0)
    seen, _ = envs.reset(seed=seeds)
    total, going = np.zeros(len(weights)), np.ones(len(weights), dtype=bool)
    task = envs.unwrapped.task
    velocity, demand = (
        task.signals.index(name) for name in ("controller.measured.velocity", "reference.value")
    )
    memory = np.zeros(len(weights))
    while going.any():
        memory += MEMORY * (seen[:, demand] - seen[:, velocity])
        actions = np.sum(weights[:, :-1] * seen, axis=1) + weights[:, -1] * memory
        seen, rewards, ended, cut, _ = envs.step(np.clip(actions, -1.0, 1.0)[:, np.newaxis])
        total += going * rewards
        going &= ~(ended | cut)
    return total.reshape(len(policies), EPISODES).mean(axis=1)


def main() -> None:
    """Print the mean return of the best policy as the search goes on, then on unseen episodes."""
    mode = "vector_entry_point"
    envs = gymnasium.make_vec("hydroservo/Velocity-v0", CANDIDATES * EPISODES, mode, **TASK)
    width = envs.single_observation_space.shape[0] + 1
    search = CMA(mean=np.zeros(width), sigma=0.3, seed=1, population_size=CANDIDATES)
    best = (-np.inf, np.zeros(width))
    for generation in range(GENERATIONS):
        policies = np.array([search.ask() for _ in range(CANDIDATES)])
        found = returns(envs, policies, seed=1000 * generation)
        search.tell([(policy, -value) for policy, value in zip(policies, found, strict=True)])
        best = max(best, (found.max(), policies[found.argmax()]), key=lambda one: one[0])
        if generation % 10 == 9:
            print(f"generation {generation + 1:3d}: mean return of the best {found.max():9.3f}")
    unseen = np.tile(search.mean, (CANDIDATES, 1))
    idle = returns(envs, 0.0 * unseen, seed=10**6)[0]
    print(f"on unseen episodes: {returns(envs, unseen, seed=10**6)[0]:.3f}; without any command {idle:.1f}")


if __name__ == "__main__":
    main()
