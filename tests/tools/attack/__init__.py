"""An attack on the program, bounded in time: `python -m tests.tools.attack [PART ...]`.

Each part is a module of this package with

    def attack(count: int, seconds: float) -> list[Row]

that tries at most so many inputs for at most so long.
"""
