"""How many visits or episodes keep up a formula throughout a window, and when.

Chains of visits for G_[a:b] F_[c:d] phi.

With w = d - c + 1, steps v_1 <= ... <= v_n at which phi holds satisfy the formula at e if

    e+a+c <= v_1 <= e+a+d,    v_{k+1} - v_k <= w,    e+b+c <= v_n,

because then every window [t+c, t+d], t in [e+a, e+b], of w steps contains a visit. Conversely, a
satisfying trace contains such a chain; how long it is depends on the trace.

- `least_visits`: with fewer no chain exists at all; a trace that visits as late as it may each
  time does with this many. This is what planning needs, and the default.
- `enough_visits`: every satisfying trace contains a chain of this length. Take v_1 as late as
  possible and each next visit the latest at most w later. Then v_2 > e+a+d (or the chain is
  complete), and v_{k+2} > v_k + w (or v_{k+1} was not the latest), so that

      v_{1+2j} >= e+a+c + j (w+1),    v_{2+2j} >= e+a+c + w + j (w+1),

  and the chain is complete as soon as the bound is e+b+c. Traces that attain the bounds exist:
  visits in pairs, one step apart, w steps after the last pair. A chain that is complete sooner
  repeats its last visit (gap 0), which is why v_n <= e+b+d loses nothing.

Where phi is asked for only at some steps, the response psi | F_[c:d] phi, take the latest visit for
the first step x_1 that asks, and so on for the first step x_k that no visit so far serves. Then
x_{k+2} >= x_k + w + 1 (`enough_responses`). An episode of psi | G_[c:d] phi ends where phi fails
between two steps that ask; they are at least w + 1 apart (`enough_episodes`).

The domains are cut to what a complete chain can use: with the slack by which the latest chain
overshoots e+b+c, nothing may come earlier than its latest value less the slack.
"""

from typing import NamedTuple

from core.stl import Interval


class Chain(NamedTuple):
    """A chain of visits; domains and bounds of the last visit relative to e [steps]."""

    count: int
    first: tuple[int, int]
    gap: tuple[int, int]
    minimum: int
    maximum: int

    @property
    def always_ends_late_enough(self) -> bool:
        """Whether the domains alone imply last >= minimum."""
        return self.first[0] + (self.count - 1) * self.gap[0] >= self.minimum

    @property
    def never_ends_too_late(self) -> bool:
        """Whether the domains alone imply last <= maximum."""
        return self.first[1] + (self.count - 1) * self.gap[1] <= self.maximum


def least_visits(length: int, width: int) -> int:
    """Visits without which no chain exists, for a window of `length` + 1 steps."""
    return -(-(length + 1) // width)


def enough_visits(length: int, width: int) -> int:
    """Visits that suffice for a chain through every satisfying trace."""
    odd = 1 + 2 * -(-length // (width + 1))
    even = 2 + 2 * max(0, -(-(length - width) // (width + 1)))
    return min(odd, even)


def enough_responses(length: int, width: int) -> int:
    """Visits that suffice to answer every step that asks, in a window of `length` + 1 steps."""
    odd = 1 + 2 * (length // (width + 1))
    even = 2 + 2 * ((length - 1) // (width + 1)) if length else 0
    return max(odd, even)


def enough_episodes(length: int, width: int) -> int:
    """Episodes of a G that suffice in a window of `length` + 1 steps."""
    return 1 + length // (width + 1)


def chain_of_visits(window: Interval, within: Interval, count: int) -> Chain:
    """Domains of a chain of `count` visits for G_window F_within."""
    width = within.stop - within.start + 1
    latest = window.start + within.stop + (count - 1) * width
    minimum = window.stop + within.start
    slack = latest - minimum
    first_latest = window.start + within.stop
    first_low = max(window.start + within.start, first_latest - slack)
    gap = (max(0, width - slack), width)
    return Chain(count, (first_low, first_latest), gap, minimum, window.stop + within.stop)
