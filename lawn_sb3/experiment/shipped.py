"""The recipes that come with the kit: in ``runs/`` of a checkout, beside the package where it was installed."""

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from lawn_sb3.experiment.registry import REPOSITORY


def shipped_recipe(path: Path) -> Path:
    """Find a recipe where there is no file of one's own.

    :param path: what the user named, such as ``runs/paper.yaml``
    :return: that, or if there is no such file the kit's own recipe of this name; if there is none, that too
    """
    if path.exists() or path.parent != Path("runs"):
        return path
    own = REPOSITORY / path
    if own.exists():
        return own
    try:
        known = files("lawn-sb3") or ()
    except PackageNotFoundError:  # used from a folder, without being installed
        return path
    installed = (Path(str(file.locate())) for file in known if file.name == path.name)
    return next((file for file in installed if file.parent.name == "lawn-sb3"), path)
