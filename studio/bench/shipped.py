"""The files of `tgpo-bench` that come with the program."""

from importlib import resources
from importlib.resources.abc import Traversable


def matrices_folder() -> Traversable:
    """Where they are, as `NAME.toml`."""
    return resources.files("studio.bench") / "matrices"


def shipped_matrices() -> list[str]:
    """Their names."""
    files = matrices_folder().iterdir()
    return sorted(file.name[:-5] for file in files if file.name.endswith(".toml"))
