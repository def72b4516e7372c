"""A film that friction is lower on until it is worn through, the same for all forward models."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Film:
    """A factor on friction, 1 − share before the film breaks and 1 after it: half of it is gone at `cycle`.

    What is left of the film is 1/(1 + (n/n_b)^k): patches of it break at cycles spread about n_b, the closer the larger
    `abruptness` k. A negative share is a film that rubs more than what lies under it.
    """

    share: float
    cycle: float
    abruptness: float

    def at(self, cycle: float) -> float:
        """The factor at a cycle."""
        left = 1.0 / (1.0 + float((cycle / self.cycle) ** self.abruptness))
        return 1.0 - self.share * left
