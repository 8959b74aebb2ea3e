"""Which games an algorithm can learn in."""

from typing import Any

from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.common.vec_env import VecEnv


def check_continuation(algorithm: type[Any], env: GymEnv | None) -> None:
    """Refuse games in which UAVs that are done go on in another way than an algorithm learns from.

    :param algorithm: its class, which says in ``continuation`` what it needs
    :param env: its environment; others than those of :func:`lawn_sb3.envs.make_vec_env` are not looked at
    :raises ValueError: if they do not fit
    """
    if not isinstance(env, VecEnv) or not env.has_attr("simulator"):
        return
    needed: str = algorithm.continuation
    if env.get_attr("simulator", [0])[0].continuation != needed:
        learns = "whole games" if needed == "episode" else "from missions that are renewed one by one"
        raise ValueError(f"{algorithm.__name__} learns {learns}: its environment needs continuation={needed!r}")
