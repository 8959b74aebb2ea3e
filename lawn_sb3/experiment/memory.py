"""What a training keeps in memory at least, so that one for which there is no room is refused before it starts."""

import os

from lawn_sb3.envs.observation import ObservationLayout
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell

BYTES = 4  # of a float32
GIB = 2**30
SLOTS_OF_SB3 = {"n_steps": 2048, "buffer_size": 1_000_000}
"""SB3's defaults for how much experience is kept."""


def experience_bytes(cell: Cell) -> int:
    """What the observations of a training take at least, for one slot of all games and in its buffer.

    :param cell: a cell that trains
    :return: bytes: a rollout holds flat observations of all games, a replay o_i of all UAVs twice, before and after
    """
    method, scenario = cell.method, cell.scenario
    layout = ObservationLayout(scenario.num_uavs, scenario.num_gbs)
    now = method.num_games * scenario.num_uavs * layout.flat_dim
    if method.algo == "mappo":
        kept = now * method.settings.get("n_steps", SLOTS_OF_SB3["n_steps"])
    elif method.algo in ("iql", "qmix"):
        slots = method.settings.get("buffer_size", SLOTS_OF_SB3["buffer_size"])
        kept = slots * scenario.num_uavs * layout.local_dim * (2 if method.algo == "iql" else 1)
    else:
        kept = now  # whole episodes, of a length that nobody knows before
    return int(BYTES * (now + kept))


def check_memory(cell: Cell) -> None:
    """Refuse a training whose experience has no room in this machine.

    :param cell: a cell that trains
    :raises UserError: with what it needs, and what there is
    """
    needed, there = experience_bytes(cell), os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > there:
        raise UserError(
            f"method {cell.key!r} on {cell.scenario.title!r} needs {needed / GIB:.0f} GiB for its observations alone, "
            f"this machine has {there / GIB:.0f}: give it fewer UAVs or GBSs, or a smaller num_games, n_steps or "
            "buffer_size"
        )
