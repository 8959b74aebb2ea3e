"""A training notices nothing of the probe: weights, random numbers, modes and games stay as they were."""

import random
from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.probe import check_policy
from tests.algos.small import ROLLOUT, parameters
from tests.experiment.probed import Masking, NormedCritic, built

ONE_EACH = ["centralized_critic", "masked", "recurrent", "monotonic_mixer", "local_q", "quantile_q"]


@pytest.mark.parametrize("policy", [*map(find_policy, ONE_EACH), Masking], ids=lambda policy: policy.__name__)
def test_a_probed_training_gives_the_same_weights_and_goes_on_with_the_same_random_numbers(
    policy: type[BasePolicy],
) -> None:
    after = []
    for probed in (False, True):
        model = built(policy)
        for seed in (random.seed, np.random.seed, th.manual_seed):
            seed(5)
        for _ in range(2):
            if probed:
                check_policy(model, "mine")
            model.learn(ROLLOUT, reset_num_timesteps=False)
        if probed:
            check_policy(model, "mine")
        after.append([*parameters(model), random.random(), np.random.random(), th.rand(1).item()])
    np.testing.assert_array_equal(after[0], after[1])


def test_modes_statistics_and_games_stay_as_they_were_even_when_a_policy_is_refused() -> None:
    model = built(NormedCritic)
    model.policy.set_training_mode(True)
    env: Any = model.get_env()
    env.reset()
    seen, weights = env.get_attr("simulator", [0])[0].state.position.copy(), parameters(model)
    with pytest.raises(UserError):
        check_policy(model, "mine")
    assert all(part.training for part in model.policy.modules())
    np.testing.assert_array_equal(parameters(model), weights)
    np.testing.assert_array_equal(env.get_attr("simulator", [0])[0].state.position, seen)
