"""What the command line refuses, and the words that it has to say; recipes and searches with one mistake each."""

from pathlib import Path
from typing import Any

import yaml

from lawn_sb3.experiment.registry import REPOSITORY
from tests.cli.running import METHODS, recipe

KEPT = REPOSITORY / "runs" / "reference" / "paper"
MAPPO: dict[str, Any] = METHODS["mappo"]


def _mappo(**changes: object) -> dict[str, Any]:
    return {"methods": {"mappo": {**MAPPO, **changes}}}


def _settings(**changes: object) -> dict[str, Any]:
    return _mappo(settings=changes)


def _player(**changes: object) -> dict[str, Any]:
    return {"methods": {"random": {"label": "Random", "player": "random", **changes}}}


RECIPES: dict[str, tuple[dict[str, Any], str]] = {
    "misspelt_key": ({"seads": [0]}, "unknown key 'seads' (did you mean 'seeds'?)"),
    "no_methods": ({"methods": {}}, "methods: must hold at least 1"),
    "no_label": ({"methods": {"random": {"player": "random"}}}, "methods.random.label is missing"),
    "text_for_methods": ({"methods": "all"}, "methods = 'all': must be keys and values"),
    "folder_for_a_name": ({"methods": {"../up": METHODS["random"]}}, "as it names a folder"),
    "misspelt_setting": (_settings(gama=1), "unknown setting of mappo: 'gama' (did you mean 'gamma'?)"),
    "setting_of_another": (_settings(buffer_size=5), "unknown setting of mappo: 'buffer_size'"),
    "infinite_rate": (_settings(learning_rate=float("inf")), "learning_rate = inf: must be a finite number"),
    "no_number": (_settings(clip_range=float("nan")), "clip_range = nan: must be a finite number"),
    "negative_clip": (_settings(clip_range=-1), "clip_range = -1: must be greater than 0"),
    "negative_discount": (_settings(gamma=-3), "gamma = -3: must be greater than or equal to 0"),
    "discount_above_one": (_settings(gamma=2), "gamma = 2: must be less than or equal to 1"),
    "no_epochs": (_settings(n_epochs=0), "n_epochs = 0: must be greater than or equal to 1"),
    "no_buffer": (
        {"methods": {"iql": {**MAPPO, "algo": "iql", "settings": {"buffer_size": 0}}}},
        "buffer_size = 0: must be greater than or equal to 1",
    ),
    "odd_batch": (_settings(batch_size=64.5), "batch_size = 64.5: must be a whole number"),
    "odd_schedule": (_settings(learning_rate="lin_x"), "a linear schedule is written lin_X with a number X"),
    "negative_schedule": (_settings(learning_rate="lin_-1"), "learning_rate = 'lin_-1': must be greater than 0"),
    "unknown_algorithm": (_mappo(algo="mapo"), "unknown algorithm 'mapo' (did you mean 'mappo'?)"),
    "unknown_policy": (_mappo(policy="stat_critic"), "did you mean 'state_critic'?"),
    "unknown_credit": (_mappo(credit="ours"), "credit = 'ours': must be 'own', 'difference' or 'team'"),
    "team_alone": (_mappo(credit="team"), "credit team needs mappo-episodes"),
    "odd_term": (_mappo(without_reward=["navi"]), "without_reward.0 = 'navi': must be 'rate', 'nav', 'col' or 'term'"),
    "no_steps": (_mappo(env_steps=0), "needs env_steps of at least 1"),
    "endless": (_mappo(env_steps=10**15), "env_steps = 1000000000000000: must be less than or equal to"),
    "true_steps": (_mappo(env_steps=True), "env_steps = True: must be a whole number"),
    "no_games": (_mappo(num_games=0), "num_games = 0: must be greater than or equal to 1"),
    "too_many_games": (_mappo(num_games=10**9), "num_games = 1000000000: must be less than or equal to 100000"),
    "negative_slack": (_mappo(slack=-1), "slack = -1: must be greater than or equal to 0"),
    "odd_baseline": (_mappo(baseline="mapo"), "unknown baseline 'mapo'; known: none"),
    "own_baseline": (_mappo(baseline="mappo"), "unknown baseline 'mappo'; known: none"),
    "odd_row": (_mappo(paper_row="MAPPO"), "paper_row = 'MAPPO': must be 'Random', 'IQL', 'QMIX' or 'CTDE-MAPPO'"),
    "unknown_player": (_player(player="randon"), "unknown player 'randon' (did you mean 'random'?)"),
    "trained_player": (_player(env_steps=5), "is a player without training: no env_steps"),
    "both": (_player(algo="mappo"), "needs either a player or an algo"),
    "neither": ({"methods": {"nobody": {"label": "N"}}}, "needs either a player or an algo"),
    "unknown_scenario": ({"scenario": "papre"}, "unknown scenario 'papre' (did you mean 'paper'?)"),
    "negative_bandwidth": ({"set": ["rb_bandwidth_hz=-5"]}, "rb_bandwidth_hz = -5: must be greater than 0"),
    "no_equals": ({"set": ["num_uavs"]}, "set 'num_uavs': expected key=value"),
    "impossible_variant": ({"variants": {"odd": ["ema_beta=2"]}}, "ema_beta = 2: must be less than 1"),
    "negative_seed": ({"seeds": [-1]}, "seeds = [-1]: whole numbers from 0 up, none twice"),
    "seed_twice": ({"seeds": [1, 1]}, "seeds = [1, 1]: whole numbers from 0 up, none twice"),
    "true_seed": ({"seeds": [True]}, "seeds.0 = True: must be a whole number"),
    "no_seeds": ({"seeds": []}, "seeds = []: must hold at least 1"),
    "text_for_seeds": ({"seeds": "0-4"}, "seeds = '0-4': must be a list"),
    "no_episodes": ({"evaluation": {"episodes": 0}}, "evaluation.episodes = 0: must be greater than or equal to 1"),
    "too_many_episodes": ({"evaluation": {"episodes": 10**13}}, "must be less than or equal to 1000000"),
    "misspelt_evaluation": ({"evaluation": {"episode": 5}}, "did you mean 'episodes'?"),
    "odd_scaling": (
        {"scaling": {"num_uavs": [2], "methods": ["mapo"]}},
        "scaling: unknown method 'mapo' (did you mean 'mappo'?)",
    ),
    "too_many_uavs": ({"scaling": {"num_uavs": [999], "methods": ["mappo"]}}, "num_uavs = 999 needs 1998 distinct"),
}
FILES = {
    "no_yaml": ("methods: [", "line 1 is not valid YAML"),
    "a_list": ("- methods", "must hold keys and values, not list"),
    "empty": ("", "must hold keys and values, not NoneType"),
    "method_twice": (
        "seeds: [0]\nmethods:\n  a: {label: A, player: random}\n  a: {label: B, player: random}\n",
        "is not valid YAML: key 'a' twice",
    ),
    "key_twice": ("seeds: [0]\nseeds: [1]\n", "is not valid YAML: key 'seeds' twice"),
}
SEARCHES: dict[str, tuple[dict[str, Any], str]] = {
    "reported_seed": ({"seeds": [0]}, "seeds [0] are among those that tiny.yaml reports"),
    "misspelt_space": ({"space": {"mappo": {"gama": [1]}}}, "unknown setting of mappo: 'gama' (did you mean 'gamma'?)"),
    "impossible_space": (
        {"space": {"mappo": {"gamma": [0.9, 7]}}},
        "impossible_space.yaml: space.mappo: method: settings: gamma = 7: must be less than or equal to 1",
    ),
    "untrained_space": ({"space": {"random": {"gamma": [0.9]}}}, "'random' is no method of tiny.yaml that trains"),
    "no_trials": ({"trials": 0}, "trials = 0: must be greater than or equal to 1"),
    "test_missions": ({"missions_seed": 20000}, "missions_seed = 20000 is that of the test missions"),
}


def write_what_is_refused(folder: Path) -> None:
    """Recipes and searches with one mistake each, and a run that is not finished."""
    for name, (mistake, _) in RECIPES.items():
        recipe(folder, **mistake).rename(folder / f"{name}.yaml")
    recipe(folder)
    for name, (text, _) in FILES.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    search = {"recipe": "tiny.yaml", "seeds": [100], "space": {"mappo": {"gamma": [0.9]}}}
    for name, (mistake, _) in SEARCHES.items():
        (folder / f"{name}.yaml").write_text(yaml.safe_dump({**search, **mistake}), encoding="utf-8")
    (folder / "unfinished").mkdir()
    (folder / "unfinished" / "config.yaml").write_bytes((KEPT / "mappo" / "seed-0" / "config.yaml").read_bytes())


SCENARIO = {
    "num_uav=5": "unknown key 'num_uav' (did you mean 'num_uavs'?)",
    "gbs_grid=[100000,100000]": "10000000000 GBSs: at most 10000",
    "gbs_grid=[0,2]": "gbs_grid = (0, 2): columns and rows must be at least 1",
    "gbs_grid=2": "gbs_grid = 2: must be a list",
    "gbs_positions_m=[]": "gbs_positions_m must hold at least one position (x, y, z) in metres",
    "gbs_positions_m=[[1,2]]": "gbs_positions_m.0.2 is missing",
    "gbs_positions_m=[[5,5,5]]": "GBS 0 at (5.0, 5.0, 5.0) m lies on a voxel centre, where the link distance would b",
    "rbs_per_gbs=0": "rbs_per_gbs = 0: every GBS needs 1 to 1000000 RBs",
    "rbs_per_gbs=[1,2]": "rbs_per_gbs names 2 GBSs, the scenario has 4",
    "rb_bandwidth_hz=.inf": "rb_bandwidth_hz = inf: must be a finite number",
    "rb_bandwidth_hz=.nan": "rb_bandwidth_hz = nan: must be a finite number",
    "tx_power_dbm=1e9": "tx_power_dbm = '1e9': must be less than or equal to 100",
    "ema_beta=0": "ema_beta = 0: must be greater than or equal to 0.000001",
    "max_slots=0": "max_slots = 0: must be greater than or equal to 1",
    "max_slots=1.5": "max_slots = 1.5: must be a whole number",
    "num_uavs=true": "num_uavs = True: no constant is true or false",
    "num_uavs=1000": "num_uavs = 1000 needs 2000 distinct origins and destinations, the airspace has 300",
    "num_uavs=[4]": "num_uavs = [4]: must be a whole number",
    "max_altitude_m=25": "max_altitude_m - min_altitude_m = 25 m must be a whole number of voxels of voxel_s",
    "min_altitude_m=30": "min_altitude_m = 30 must lie below max_altitude_m = 30",
    "voxel_size_m=0": "voxel_size_m = 0: must be greater than or equal to 0.001",
    "max_voxel_steps=0": "max_voxel_steps = 0: must be greater than or equal to 1",
    "path_loss_exponent=-2": "path_loss_exponent = -2: must be greater than 0",
    "fail_penalty=-1": "fail_penalty = -1: must be greater than or equal to 0",
    "rate_unit=kbps": "rate_unit = 'kbps': must be 'lone-uav' or 'mbps', or must be a number",
    "rate_unit=-3": "rate_unit = -3: must be 'lone-uav' or 'mbps', or must be greater than 0",
    "arrived_uav=flies": "arrived_uav = 'flies': must be 'leaves' or 'stays'",
    "name=[1]": "name = [1]: must be text",
    "width_voxels=100000": "width_voxels = 100000: must be less than or equal to 10000",
}
"""Changes of the scenario ``paper``."""
SETTINGS = {
    "learning_rate=lin_x": "learning_rate = 'lin_x': a linear schedule is written lin_X with a number X",
    "gamma=-3": "gamma = -3: must be greater than or equal to 0",
    "gamma=2": "gamma = 2: must be less than or equal to 1",
    "gamma=true": "gamma = True: must be a number",
    "gamma=high": "gamma = 'high': must be a number",
    "learning_rate=.inf": "learning_rate = inf: must be a finite number",
    "learning_rate=0": "learning_rate = 0: must be greater than 0",
    "learning_rate=-1": "learning_rate = -1: must be greater than 0",
    "clip_range=.nan": "clip_range = nan: must be a finite number",
    "clip_range=-1": "clip_range = -1: must be greater than 0",
    "n_epochs=0": "n_epochs = 0: must be greater than or equal to 1",
    "n_epochs=1.5": "n_epochs = 1.5: must be a whole number",
    "n_steps=0": "n_steps = 0: must be greater than or equal to 1",
    "batch_size=1": "batch_size = 1: must be greater than or equal to 2",
    "batch_size=64.5": "batch_size = 64.5: must be a whole number",
    "ent_coef=-1": "ent_coef = -1: must be greater than or equal to 0",
    "vf_coef=lin_1": "vf_coef = 'lin_1': must be a number",
    "max_grad_norm=0": "max_grad_norm = 0: must be greater than 0",
    "gae_lambda=1.1": "gae_lambda = 1.1: must be less than or equal to 1",
    "policy_kwargs=5": "policy_kwargs = 5: must be keys and values",
    "normalize_value=maybe": "normalize_value = 'maybe': must be true or false",
    "autocast=float16": "autocast = 'float16': must be 'bfloat16'",
}
"""Settings of MAPPO that no algorithm can take."""
INVALID = {
    "train --out new --env-steps 0": "'--env-steps': Input should be greater than or equal to 1",
    "evaluate --player random --seed -1": "'--seed': Input should be greater than or equal to 0",
    "evaluate --player random --episodes 1000000000000": "'--episodes': Input should be less than or equal to 1000000",
    "evaluate --player random --episodes 0": "'--episodes': Input should be greater than or equal to 1",
    "evaluate --player random --episodes two": "'--episodes': Input should be a valid integer, unable to parse string ",
    "train --out new --num-games 0": "'--num-games': Input should be greater than or equal to 1",
    "train --out new --seed x": "'--seed': Input should be a valid integer, unable to parse string as an integer",
    "plan --player welfare --episodes 0": "'--episodes': Input should be greater than or equal to 1",
    "plan --player welfare --starts 0": "'--starts': Input should be greater than or equal to 1",
    "reproduce tiny.yaml --jobs 0": "'--jobs': Input should be greater than or equal to 1",
    "reproduce tiny.yaml --jobs x": "'--jobs': Input should be a valid integer, unable to parse string as an integer",
    "tune --jobs 0": "'--jobs': Input should be greater than or equal to 1",
    "identify --episodes 0": "'--episodes': Input should be greater than or equal to 1",
}
"""Commands with an option whose value is none."""
OTHERS = {
    "halp": "No such command 'halp'.",
    "train": "Missing option '--out'.",
    "train --out new --sed 1": "No such option: --sed (Possible options: --seed, --seeds, --set)",
    "train --out new --algo mapo": "method: unknown algorithm 'mapo' (did you mean 'mappo'?)",
    "train --out new --policy stat_critic": "unknown policy 'stat_critic' (did you mean 'state_critic'?)",
    "train --out new -params gama=1": "method: unknown setting of mappo: 'gama' (did you mean 'gamma'?)",
    "train --out new --scenario papre": "unknown scenario 'papre' (did you mean 'paper'?)",
    "train --out new --set rb_bandwidth_hz=-5": "scenario 'paper': rb_bandwidth_hz = -5: must be greater than 0",
    "train --out new --recipe tiny.yaml --method mapo": "unknown method 'mapo' (did you mean 'mappo'?); known: mappo, ",
    "train --out new --recipe tiny.yaml": "name both --recipe FILE and --method NAME, or neither",
    "train --out .": "--out '.' holds other files than a run's: name a new folder",
    "train --out tiny.yaml": "--out 'tiny.yaml' is a file, not a folder",
    "evaluate": "name either --run DIR or --player NAME",
    "evaluate --player randon": "unknown player 'randon' (did you mean 'random'?)",
    "evaluate --player random --set num_uavs": "--set 'num_uavs': expected key=value",
    "evaluate --player random --scenario nowhere.yaml": "scenario file 'nowhere.yaml' cannot be read: No such file or ",
    "evaluate --player bound --regret": "--regret: the UAVs of 'bound' never meet, so none has others to respond to",
    "evaluate --run nowhere": "'nowhere' holds no run: config.yaml: No such file or directory",
    "evaluate --run unfinished": "'unfinished' is not finished, or its policy file has changed since",
    f"evaluate --run {KEPT}/random/seed-0 --set gbs_grid=[3,3]": f"'{KEPT}/random/seed-0' was trained for 4 GBSs, v_ma",
    "verify nowhere": "'nowhere' holds no run: config.yaml: No such file or directory",
    "verify unfinished": "'unfinished' is not finished, or its policy file has changed since",
    "replay --out page.html": "name at least one --run DIR or --player NAME",
    "replay --player randon --out page.html": "unknown player 'randon' (did you mean 'random'?)",
    "replay --player bound --out page.html": "'bound' cannot be shown: its UAVs never meet, each has a game of its own",
    "replay --player random --out page.txt": "a file that ends in .html, .gif, .mp4, .png, .pdf, .svg",
    "replay --player random --out none/page.html": "'none/page.html' cannot be written: there is no folder 'none'",
    "replay --player random --episodes 3 --episode 3 --out page.html": "--episode 3: from 0 to 2, as --episodes 3",
    "replay --player random --episode 1 --episode 2 --out film.gif": "--episode: .gif shows one episode, a page",
    "replay --player random --slot 3 --out page.html": "--slot: only a picture shows one slot, not .html",
    f"replay --run {KEPT}/random/seed-0 --run unfinished --out page.html": "'unfinished' is not finished, or its ",
    "replay --run nowhere --out page.html": "'nowhere' holds no run: config.yaml: No such file or directory",
    f"replay --run {KEPT}/random/seed-0 --set gbs_grid=[3,3] --out page.html": "was trained for 4 GBSs, v_max 3; ",
    "runs nowhere": "'nowhere' is no folder",
    f"compare {KEPT}/mappo/seed-0": "name at least two runs: the others are compared with the first",
    "compare nowhere tiny.yaml": "'nowhere' is no folder",
    "compare unfinished unfinished": "each run can be named once",
    f"compare {KEPT}/mappo {KEPT}/iql --figure one.txt": "--figure 'one.txt': a file that ends in .png, .pdf, .svg",
    "train --out new --seeds 4-0": "--seeds '4-0': whole numbers from 0 up and ranges such as 0-4, with commas between",
    "train --out new --seeds 0-x": "--seeds '0-x': whole numbers from 0 up and ranges such as 0-4, with commas between",
    "train --out new --seeds 0,0": "--seeds '0,0': each seed once",
    "train --out new --seeds 0-1 --seed 3": "name --seed K or --seeds K-L, not both",
    "train --out new --jobs 2": "--jobs, --backend and --address: only for several runs, with --seeds",
    "train --out new --seeds 0-1 --backend slurm": "unknown backend 'slurm'; known: local, ray",
    "train --out tiny.yaml --seeds 0-1": "--out 'tiny.yaml' is a file, not a folder",
    "plan --player equilibrum": "unknown planner 'equilibrum' (did you mean 'equilibrium'?)",
    "plan --player shortest-path --slack 1": "planner 'shortest-path' has no slack: it takes none",
    "ceiling --player forcast": "unknown player 'forcast' (did you mean 'forecast'?)",
    "ceiling --run nowhere": "'nowhere' holds no run: config.yaml: No such file or directory",
    f"ceiling --run {KEPT}/mappo/seed-0": f"'{KEPT}/mappo/seed-0' was trained on 'paper', not on 'tiny'",
    "scenario papre": "unknown scenario 'papre' (did you mean 'paper'?)",
    "scenario --set arrival=never": "scenario 'paper': arrival = 'never': must be 'slot-end' or 'fly-through'",
    "scenario --picture airspace.txt": "--picture 'airspace.txt': a file that ends in .png, .pdf, .svg",
    "reproduce nowhere.yaml": "recipe file 'nowhere.yaml' cannot be read: No such file or directory",
    "reproduce tiny.yaml --backend rey": "unknown backend 'rey' (did you mean 'ray'?); known: local, ray",
    "reproduce tiny.yaml --address 10.0.0.1:6379": "--address '10.0.0.1:6379' is that of a cluster: add --backend ray",
    "ablate state_critic --recipe tiny.yaml --backend rey": "unknown backend 'rey' (did you mean 'ray'?)",
    "ablate nobody": "unknown policy 'nobody'",
    "ablate state_critic --recipe nowhere.yaml": "recipe file 'nowhere.yaml' cannot be read: No such file or directory",
    "report nowhere.yaml": "recipe file 'nowhere.yaml' cannot be read: No such file or directory",
    "report tiny.yaml": "no runs in 'tiny': run lawn-sb3 reproduce tiny.yaml first",
    "report tiny.yaml --runs nowhere": "no runs in 'nowhere': run lawn-sb3 reproduce tiny.yaml first",
    "export tiny.yaml": "'tiny/random/seed-0': not finished, or made with another configuration",
    "export tiny.yaml --to .": "--to '.' holds something else than an earlier export: name a new folder",
    "tune nowhere.yaml": "search file 'nowhere.yaml' cannot be read: No such file or directory",
    'evaluate --player random --set "=5"': "--set '=5': expected key=value",
    'evaluate --player random --set "num_uavs=[1"': "--set 'num_uavs=[1': the value is not valid YAML",
    "evaluate --player random --set width_voxels=10000 --set length_voxels=10000": "scenario 'paper': the grid (10000,",
    "evaluate --player random --scenario .": "unknown scenario '.'; known: a path ending in .yaml, as-printed, paper, ",
    "evaluate --player random --scenario a_folder.yaml": "scenario file 'a_folder.yaml' cannot be read: No such file o",
    "evaluate --player random --run x": "name either --run DIR or --player NAME",
    'evaluate --player ""': "unknown player ''",
    'evaluate --run ""': "'.' holds no run: config.yaml: No such file or directory",
    "evaluate --run tiny.yaml": "'tiny.yaml' holds no run: config.yaml: Not a directory",
    "evaluate --run .": "'.' holds no run: config.yaml: No such file or directory",
    "train --out new --algo iql -params buffer_size=0": "method: settings: buffer_size = 0: must be greater than or eq",
    "train --out new --algo iql -params train_freq=0": "method: settings: train_freq = 0: must be greater than or equa",
    "train --out new --algo iql -params train_freq=[1]": "method: settings: train_freq = [1]: must be a whole number",
    "train --out new --algo qmix -params exploration_fraction=2": "method: settings: exploration_fraction = 2: must be",
    "train --out new --algo qmix -params tau=0": "method: settings: tau = 0: must be greater than 0",
    "train --out new --algo qmix -params target_update_interval=0": "method: settings: target_update_interval = 0: mus",
    "train --out new --without-reward all": "No such option: --without-reward",
    "train --out new --slack -1": "No such option: --slack",
    "scenario .yaml": "unknown scenario '.yaml'; known: a path ending in .yaml, as-printed, paper, tiny",
    "reproduce .": "recipe file '.' cannot be read: Is a directory",
    "report tiny.yaml --out tiny.yaml": "no runs in 'tiny': run lawn-sb3 reproduce tiny.yaml first",
}
"""Other commands."""

REFUSED = {
    **{f"evaluate --player random --set {change}": f"scenario 'paper': {words}" for change, words in SCENARIO.items()},
    **{f"train --out new -params {setting}": f"method: settings: {words}" for setting, words in SETTINGS.items()},
    **{command: f"Invalid value for {words}" for command, words in INVALID.items()},
    **OTHERS,
    **{f"reproduce {name}.yaml": words for name, (_, words) in RECIPES.items()},
    **{f"reproduce {name}.yaml": words for name, (_, words) in FILES.items()},
    **{f"tune {name}.yaml": words for name, (_, words) in SEARCHES.items()},
}
