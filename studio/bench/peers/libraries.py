"""Other libraries, which need not be installed."""

from importlib import import_module
from typing import Any


def library(name: str) -> Any:
    """A module of the extra `peers`.

    A run without it ends at once and is kept nowhere, so that it is tried again.
    """
    try:
        return import_module(name)
    except ImportError as error:
        package = name.split(".", 1)[0]
        raise SystemExit(
            f"{package} cannot be imported ({error}): pip install 'tgpo-studio[peers]'"
        ) from error
