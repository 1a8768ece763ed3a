"""What Gymnasium's entry point calls: every shipped task and demo gets an identifier.

Gymnasium 1.0 has given up entry points; with it, `register()` is called by hand.
"""

from importlib.util import find_spec
from pathlib import Path

from gymnasium.envs import registration

NAMESPACE = "tgpo"

VERSION = 0
"""Of all environments: a later one may observe or pay something else."""


def register() -> None:
    """Register `tgpo/<task>-v0` for each shipped task and demo that is not registered yet."""
    for task in shipped():
        name = f"{NAMESPACE}/{task}-v{VERSION}"
        if name not in registration.registry:
            registration.register(
                id=name, entry_point="studio.gym.environment:StlEnv", kwargs={"task": task}
            )


def shipped() -> list[str]:
    """Names of the tasks and demos, from the files alone: Gymnasium must not wait for JAX."""
    spec = find_spec("scenes")
    folders = [] if spec is None else spec.submodule_search_locations or []
    files = [file for folder in folders for file in Path(folder).glob("*/*.toml")]
    return sorted(f"{file.parent.name}-{file.stem}" for file in files)
