"""How large the padded arrays of a formula are.

Programs are compiled for sizes, not for formulas. Nearly all missions have the first sizes; larger
ones are compiled for when a formula needs them. What the networks of the studio mode see does not
depend on the sizes (`core.mdp.studio_mode`), so weights serve all of them.
"""

from dataclasses import dataclass, replace

from core.errors import UserError


class GroundingError(UserError):
    """A formula too large for the padded arrays."""


@dataclass(frozen=True)
class Sizes:
    """Capacities: what a formula may have at most."""

    variables: int
    subgoals: int
    constraints: int
    compounds: int
    """State formulas that are neither a region nor a negated region."""
    literals: int
    """Alternatives of a state formula, and regions of an alternative."""
    requirements: int
    doors: int
    """Sets of obstacles that open and close independently; further ones share the last."""

    def hold(self, needed: "Sizes") -> bool:
        """Whether variables, tasks and requirements fit; state formulas are sized apart."""
        return all(
            getattr(needed, name) <= getattr(self, name)
            for name in ("variables", "subgoals", "constraints", "requirements")
        )


STANDARD = Sizes(8, 12, 24, 8, 4, 4, 3)
LARGE = Sizes(16, 32, 64, 8, 4, 16, 5)
LARGEST = Sizes(32, 64, 160, 32, 16, 64, 5)
"""The most that is supported. Literals cost the most time: all of them are looked up at each step,
so state formulas get more room only if they need it."""

_NOUNS = {
    "variables": "time and branch variables",
    "subgoals": "subgoals",
    "constraints": "invariant constraints",
    "compounds": "different state formulas that are neither a region nor a negated region",
    "requirements": "requirements on repeated visits",
}


def check_counts(needed: dict[str, int]) -> None:
    """Refuse counts beyond the largest sizes, before anything is built.

    Raises:
        GroundingError: with the number, and what is allowed.
    """
    for name, count in needed.items():
        most = getattr(LARGEST, name)
        if count > most:
            raise GroundingError(
                f"the formula needs {count:,} {_NOUNS[name]}, but at most {most:,} are supported; "
                "shorten the formula or split the mission"
            )


def sizes_for(needed: Sizes) -> Sizes:
    """The smallest sizes that hold what is needed; more doors alone ask for larger ones too."""
    fitting = [sizes for sizes in (STANDARD, LARGE, LARGEST) if sizes.hold(needed)]
    chosen = next((sizes for sizes in fitting if needed.doors <= sizes.doors), fitting[-1])
    compounds, literals = (
        next(size for size in (getattr(STANDARD, name), getattr(LARGEST, name)) if count <= size)
        for name, count in (("compounds", needed.compounds), ("literals", needed.literals))
    )
    return replace(chosen, compounds=compounds, literals=literals)
