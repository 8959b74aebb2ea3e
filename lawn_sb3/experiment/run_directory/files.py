"""What a run leaves: the files of its folder, of which there is one per method and seed."""

CONFIG_FILE = "config.yaml"
"""What the run depends on: seed, method, scenario and evaluation with all defaults, and a hash of the policy's
file and of the user's modules that it imports."""
PROVENANCE_FILE = "provenance.json"
"""Where it comes from: command, commit, versions, hardware, and the seconds that training and evaluation took."""
CHECKPOINT_FILE = "checkpoint.bin"
"""All that an interrupted training needs to go on, after its SHA-256; removed at the end."""
CHECKPOINT_BEFORE_FILE = "checkpoint_before.bin"
"""The checkpoint before, should that one be damaged."""
PROGRESS_FILE = "progress.csv"
"""The training curve; see ``progress``. Like all up to the model, only of methods that train."""
TENSORBOARD_FOLDER = "tensorboard"
"""The same curve for TensorBoard, with times."""
MODEL_FILE = "model.zip"
"""The trained model: weights as Stable-Baselines3 saves them, settings as JSON."""
WEIGHTS_FILE = "weights.npz"
"""The networks alone: what reference results keep instead of the model."""
TENSORS_FILE = "weights.safetensors"
"""The networks alone, unrounded, for whoever reads them without this kit."""
CARD_FILE = "README.md"
"""The model card: what was trained, on which game, what came out, how it is made again, flown and read."""
EVALUATION_FILE = "evaluation.csv"
"""The test missions as they were flown: :func:`.columns.evaluation_columns`."""
SAMPLED_FILE = "evaluation_sampled.csv"
"""The same missions flown once more with sampled actions, where a trained method is evaluated greedily."""
SLOTS_FILE = "slots.csv"
"""How the cells filled: :func:`.columns.slots_columns`."""
PATHS_FILE = "paths.csv"
"""Where the UAVs of the first episodes went: :func:`.columns.paths_columns`."""
REGRET_FILE = "regret.csv"
"""What each UAV could have gained by deviating alone, if the recipe asks for it: :func:`.columns.regret_columns`."""
SCALING_FILE = "scaling.csv"
"""What came out with other numbers of UAVs, if the recipe asks for it: :func:`.columns.scaling_columns`."""
COSTS_FILE = "costs.csv"
"""What a decision costs then, if the recipe asks for that too: :func:`.columns.costs_columns`."""
MANIFEST_FILE = "manifest.json"
"""What vouches for the others: how the run was made, and the SHA-256 of each file."""
LOG_FILE = "worker.log"
"""What the run printed where others ran side by side; removed at the end if there is nothing in it."""
LOCK_FILE = "lock"
"""Who is writing here now; removed when they end."""
FINISHED_FILE = "finished"
"""The fingerprint of the configuration; written last, so that a run without it is not complete."""

RESULT_FILES = (
    EVALUATION_FILE,
    SLOTS_FILE,
    PATHS_FILE,
    SAMPLED_FILE,
    SCALING_FILE,
    COSTS_FILE,
    REGRET_FILE,
    PROGRESS_FILE,
    PROVENANCE_FILE,
)
"""All that the report reads, besides the configuration."""
ABLATION_FILES = (EVALUATION_FILE, SCALING_FILE, PROGRESS_FILE, PROVENANCE_FILE)
"""What is kept of an ablation's run: all that its report reads. There are too many methods to keep a model of each."""
