"""Adding a policy of one's own to a recipe of ablations."""

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.recipe import Method, Recipe, honest_label
from lawn_sb3.experiment.registry import algorithm_for


def with_policy(recipe: Recipe, policy: str) -> tuple[Recipe, str]:
    """Add a policy to an ablation: the default method of its algorithm, with this policy instead.

    :param recipe: the recipe
    :param policy: the policy's name
    :return: the recipe with one method more, and the method's key
    :raises UserError: if no method of the recipe can be changed so, or one has this policy already
    """
    algo = algorithm_for(find_policy(policy))
    defaults = {own.algo: key for key, own in reversed(recipe.methods.items()) if own.algo and own.baseline is None}
    if algo not in defaults:
        known = ", ".join(sorted(filter(None, defaults)))
        raise UserError(
            f"policy {policy!r} is for {algo or 'no algorithm of the kit'}; recipe {recipe.name!r} has default methods "
            f"of: {known}"
        )
    for key, own in recipe.methods.items():
        if own.policy is not None and find_policy(own.policy) is find_policy(policy):
            raise UserError(f"recipe {recipe.name!r} has policy {policy!r} already: it is the method {key!r}")
    name, base = policy.rpartition(":")[2], defaults[algo]
    if name in (*recipe.methods, "report") or not name.isidentifier():
        raise UserError(f"the runs of {name!r} need a folder of that name in runs/{recipe.name}: rename the policy")
    changes = {"label": honest_label(name, recipe.methods[base].settings), "policy": policy, "baseline": base}
    values = recipe.methods[base].model_dump() | changes | {"paper_row": None}
    return recipe.model_copy(update={"methods": {**recipe.methods, name: Method.model_validate(values)}}), name
