"""`--new`: a scene file to begin with."""

from pathlib import Path

from core.errors import UserError
from scenes import blank, save_scene
from studio.options import Options

SUFFIX = ".stl.toml"
LONGEST_NAME = 80  # characters, as of a scene's name


def begin(options: Options) -> int:
    """Write a new scene file and print its name; returns the exit status.

    Raises:
        UserError: no such robot, or the file exists or cannot be written.
    """
    assert options.new is not None
    path = Path(f"{options.new}{SUFFIX}") if options.out is None else options.out
    name = path.name.removesuffix(SUFFIX).strip()[:LONGEST_NAME]
    scene = blank(options.new, options.variant or "", name or "new")
    if path.exists():
        raise UserError(f"{path}: exists already; give another file with --out FILE{SUFFIX}")
    save_scene(scene, path)
    print(path, flush=True)
    return 0
