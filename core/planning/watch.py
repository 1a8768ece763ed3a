"""What is known of a search while it runs, and how it is told to stop."""

import math
import threading
from dataclasses import dataclass, field


@dataclass(eq=False)
class Watch:
    """Written by the search after each program, read by others; `stop` the other way round.

    Attributes:
        robustness: Of the best trace so far [m]; -inf before the first.
        bound: That no trace exceeds, as far as is proved [m].
        stop: Once set, the search ends with what it has.
    """

    robustness: float = -math.inf
    bound: float = math.inf
    stop: threading.Event = field(default_factory=threading.Event)
