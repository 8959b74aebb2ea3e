"""Finding a backend by its name, without loading what the others need."""

import os
from importlib.util import find_spec

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.backends.job import Backend
from lawn_sb3.experiment.backends.local import LocalBackend

BACKENDS = ("local", "ray")
SIDE_BY_SIDE = 2
"""Jobs at a time on this machine, if nobody says how many."""

TRIES = "RAY_NUM_REDIS_GET_RETRIES"
"""How often Ray tries an address, which it reads as it is imported; for minutes by default."""


def find_backend(name: str, side_by_side: int | None = None, address: str | None = None) -> Backend:
    """Find a backend, ready to work.

    :param name: ``local``: processes of this machine; ``ray``: a Ray cluster
    :param side_by_side: how many jobs at a time; by default two here, and as many as a cluster has room for
    :param address: where the cluster is, as Ray writes it; by default ``RAY_ADDRESS``, or one that runs on this machine
    :return: the backend
    :raises UserError: if there is none of that name, or no cluster answers
    """
    if name not in BACKENDS:
        raise unknown_name("backend", name, BACKENDS)
    if name == "local":
        if address is not None:
            raise UserError(f"--address {address!r} is that of a cluster: add --backend ray")
        return LocalBackend(side_by_side or SIDE_BY_SIDE)
    if find_spec("ray") is None:
        raise UserError("--backend ray needs Ray, which is not installed here: pip install 'lawn-sb3[cluster]'")

    os.environ.setdefault(TRIES, "1")

    from lawn_sb3.experiment.backends.ray_cluster import RayBackend

    return RayBackend(address, side_by_side)
