"""`python -m tests.tools.attack [part ...] [--count N] [--seconds S]`: attack the product.

Everything stays on this machine, on the loopback interface, and ends in bounded time. Prints a
table; exits with 1 if anything failed.
"""

import argparse
import importlib
import pkgutil
import sys
from types import ModuleType

import tests.tools.attack as package
from tests.tools.attack.table import table


def parts() -> dict[str, ModuleType]:
    """The modules of this folder that have a function `attack(count, seconds)`, by name."""
    names = [found.name for found in pkgutil.iter_modules(package.__path__)]
    modules = {
        name: importlib.import_module(f"{package.__name__}.{name}")
        for name in names
        if name != "__main__"
    }
    return {name: module for name, module in modules.items() if hasattr(module, "attack")}


def main() -> int:
    """Run the parts that are named, all by default."""
    known = parts()
    parser = argparse.ArgumentParser(prog="python -m tests.tools.attack", description=__doc__)
    parser.add_argument("part", nargs="*", help=f"of {', '.join(known)}; all by default")
    parser.add_argument("--count", type=int, default=1000, help="attempts of each part")
    parser.add_argument("--seconds", type=float, default=60.0, help="limit for each part")
    options = parser.parse_args()
    unknown = sorted(set(options.part) - set(known))
    if unknown:
        parser.error(f"unknown part {unknown[0]!r}; known: {', '.join(known)}")
    rows = []
    for name in options.part or known:
        rows += known[name].attack(options.count, options.seconds)
    print(table(rows))
    return 1 if any(row.failures for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
