"""Scenarios as environments of Gymnasium; importing this registers them::

    import gymnasium
    import hydroservo.gym

    env = gymnasium.make("hydroservo/Velocity-v0", scenario="rig/1khz-pi-square")
    envs = gymnasium.make_vec("hydroservo/Position-v0", 4096, vectorization_mode="vector_entry_point")

``gymnasium.make("hydroservo.gym:hydroservo/Velocity-v0")`` imports it too.
"""

import gymnasium

from hydroservo.gym.environments import LoopEnv, LoopVectorEnv
from hydroservo.gym.task import Task

__all__ = ["LoopEnv", "LoopVectorEnv", "Task"]

for signal, scenario in (("velocity", "rig/1khz-pi-sine"), ("position", "axis/position")):
    gymnasium.register(
        f"hydroservo/{signal.capitalize()}-v0",
        entry_point="hydroservo.gym.environments:LoopEnv",
        vector_entry_point="hydroservo.gym.environments:LoopVectorEnv",
        kwargs={"signal": signal, "scenario": scenario},
    )
