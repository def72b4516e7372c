"""Damage that moves with the material and vanishes with what is worn off: Miner's sum at points of a body.

Points stand in c columns into the body's depth, fixed in its own axes, at z levels below the unworn surface. How fast
damage grows is known at wear states as a share of life per cycle, at d depths below the worn surface. Between states
its logarithm goes by a straight line over that of the cycles, and the worn depth as stated. So neither the jumps of a
run nor its mesh lines are steps of the sum.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil

import numpy as np
from scipy.integrate import cumulative_trapezoid

from geometry.arrays import Array, BoolArray
from wirewear.test.life import ENDURANCE_cycles

FLOOR = -30.0  #: Decimal logarithm of the share of life per cycle where there is none.
#: Steps of the sum between two wear states at least, and at most.
_STEPS = (16, 400)
_LEVELS = 4  #: Levels at which sums are kept, for each spacing of the depths of rates.
_PER_LAYER = 4.0  #: Steps while the surface recedes by the uppermost spacing of depths.


@dataclass(frozen=True, eq=False)
class Rates:
    """Decimal logarithms (c, d) of the share of life that a cycle takes at the wear state of `cycle`; FLOOR for 0."""

    cycle: int
    share: Array


@dataclass(frozen=True)
class Span:
    """Cycles after `start` up to and with `end` under the same conditions, and rates found then, in order."""

    start: float
    end: float
    rates: tuple[Rates, ...]


@dataclass(frozen=True, eq=False)
class Ahead:
    """Cycles under the same conditions that would follow a run: their number, what each takes of life (as found last
    under them), and the depth (c,) in mm that each wears.
    """

    cycles: float
    rates: Rates
    speed_mm: Array


@dataclass(frozen=True, eq=False)
class Sum:
    """Miner's sum (c, z) in columns at levels after `cycle` cycles, and the depths (c,) in mm worn off by then."""

    cycle: float
    damage: Array
    worn_mm: Array


@dataclass(frozen=True)
class Initiation:
    """Where a damage sum is first reached: after how many cycles, in which column, at which level (indices). beyond:
    True if it is not while the run lasts, but if it went on.
    """

    cycles: float
    column: int
    level: int
    beyond: bool


@dataclass(frozen=True, eq=False)
class Damage:
    """Fatigue damage in c columns of points below a body's surface as it wears.

    depths_mm (d,): of the rates below the worn surface, from 0. spans: the cycles of the run. worn_mm: gives the depths
    (c,) worn off after a number of cycles. ahead: what would follow, again and again: a turn of the programme; empty
    for nothing.
    """

    depths_mm: Array
    spans: Sequence[Span]
    worn_mm: Callable[[float], Array]
    ahead: Sequence[Ahead] = ()

    @property
    def end(self) -> float:
        """Number of the last cycle of the run."""
        return self.spans[-1].end

    @cached_property
    def levels_mm(self) -> Array:
        """Depths (z,) below the unworn surface at which sums are kept; close to each other as far as the body wears."""
        deepest, count = float(self.worn_mm(self.end).max()), len(self.depths_mm)
        below = np.interp(np.arange(0.0, count - 1.0 + 1e-9, 1.0 / _LEVELS), np.arange(count), self.depths_mm)
        return np.unique(np.concatenate([np.arange(0.0, deepest, below[1]), deepest + below]))

    def present(self, worn_mm: Array) -> BoolArray:
        """True (c, z) for points not yet worn off, from the depth worn_mm (c,) of each column."""
        return np.asarray(self.levels_mm >= worn_mm[:, None] - 1e-12)

    def of_present(self, now: Sum) -> Array:
        """Damage sum (c, z), zero where worn off; a column's uppermost present level has the sum at the surface."""
        present = self.present(now.worn_mm)
        there = np.where(present, now.damage, 0.0)
        columns, top = np.arange(len(there)), np.minimum(present.argmax(axis=1), there.shape[1] - 2)
        levels = self.levels_mm
        # The surface has come as far as between two levels: the sum goes on in a straight line from those below.
        part = (levels[top] - now.worn_mm) / (levels[top + 1] - levels[top])
        own = there[columns, top]
        there[columns, top] = np.maximum(own, own + part * (own - there[columns, top + 1]))
        return there

    def course(self, until: float | None = None) -> Iterator[Sum]:
        """Yields the sum after each step, from the test's start up to cycle `until` or, for None, the run's end."""
        stop = self.end if until is None else min(until, self.end)
        damage = np.zeros((len(self.worn_mm(0.0)), len(self.levels_mm)))
        for span in self.spans:
            bounds = [span.start, *(one.cycle for one in span.rates if span.start < one.cycle < span.end), span.end]
            for first, last in pairwise(bounds):
                for begin, end in pairwise(self._steps(first, min(last, stop), span)):
                    middle = 0.5 * (begin + end)
                    rate = self._rate(_between(span.rates, middle), self.worn_mm(middle))
                    damage = damage + (end - begin) * rate
                    yield Sum(end, damage, self.worn_mm(end))

    def at(self, cycle: float) -> Sum:
        """The damage summed over the run's first `cycle` cycles."""
        *_, last = self.course(cycle)
        return last

    def initiations(self, sums: Sequence[float]) -> list[Initiation | None]:
        """For each of `sums`: where that damage sum is first reached in material not worn off; None if it never is."""
        found: list[Initiation | None] = [None] * len(sums)
        cycle, largest = 0.0, 0.0
        for now in self._followed():
            there = self.of_present(now)
            place = np.unravel_index(int(there.argmax()), there.shape)
            for k, asked in enumerate(sums):
                if found[k] is None and there[place] >= asked:
                    part = (asked - largest) / (there[place] - largest)
                    begins = float(cycle + part * (now.cycle - cycle))
                    found[k] = Initiation(begins, int(place[0]), int(place[1]), beyond=begins > self.end)
            cycle, largest = now.cycle, float(there[place])
            if None not in found:
                break
        if not self.ahead:
            return found
        return [self._later(now, asked) if one is None else one for one, asked in zip(found, sums, strict=True)]

    def _followed(self) -> Iterator[Sum]:
        """The sum after each step of the run, and of as many turns of its programme as must be followed."""
        for now in self.course():
            yield now
        turn = sum(block.cycles for block in self.ahead)
        # Turns of a programme that are followed block by block. Later on a life is off by less than one turn, 0.5 % of
        # it.
        while len(self.ahead) > 1 and now.cycle < 200 * turn:
            for block in self.ahead:
                there = self.levels_mm[-1] >= now.worn_mm
                receded = block.cycles * float(block.speed_mm[there].max(initial=0.0))
                count = max(ceil(_PER_LAYER * receded / self.depths_mm[1]), 1)
                step = block.cycles / count
                for _ in range(count):
                    rate = self._rate(block.rates.share, now.worn_mm + 0.5 * step * block.speed_mm)
                    worn = now.worn_mm + step * block.speed_mm
                    now = Sum(now.cycle + step, now.damage + step * rate, worn)
                    yield now

    def _later(self, last: Sum, asked: float) -> Initiation | None:
        """Where a sum is reached first if cycles go on, each with its share of what follows the run."""
        turn = sum(block.cycles for block in self.ahead)
        share = np.log10(sum(block.cycles / turn * 10.0**block.rates.share for block in self.ahead))
        speed = np.asarray(sum(block.cycles / turn * block.speed_mm for block in self.ahead))
        rates = self._rate(share, last.worn_mm)
        # Depths at which is known what a point gathers on its way to the surface.
        fine = np.linspace(0.0, self.depths_mm[-1], 400)
        passed = cumulative_trapezoid(self._rate_at(share, np.tile(fine, (len(share), 1))), fine, axis=1, initial=0.0)
        there, first = self.of_present(last), Initiation(np.inf, 0, 0, beyond=True)
        for column, depths in enumerate(self.levels_mm - last.worn_mm[:, None]):
            lacking, rate = asked - there[column], rates[column]
            cycles = np.divide(lacking, rate, out=np.full_like(rate, np.inf), where=rate > 0.0)
            # Where less is worn off meanwhile than can be distinguished, damage goes on where it is.
            moves = speed[column] * np.minimum(cycles, ENDURANCE_cycles) > fine[1]
            if moves.any():
                # On its way to the surface a point gathers what lies between, over the speed of the surface.
                still = np.interp(depths, fine, passed[column]) - lacking * speed[column]
                gathered, at = np.unique(passed[column], return_index=True)
                taken = (depths - np.interp(still, gathered, fine[at])) / speed[column]
                taken[(still < 0.0) | (depths < 0.0)] = np.inf
                cycles = np.where(moves, taken, cycles)
            level = int(cycles.argmin())
            if last.cycle + cycles[level] < first.cycles:
                first = Initiation(float(last.cycle + cycles[level]), column, level, beyond=True)
        return first if np.isfinite(first.cycles) else None

    def _steps(self, first: float, last: float, span: Span) -> Array:
        if last <= first:
            return np.zeros(0)
        receded = float((self.worn_mm(last) - self.worn_mm(first)).max())
        if receded == 0.0 and len(span.rates) == 1:
            return np.array([first, last])
        count = int(np.clip(ceil(_PER_LAYER * receded / self.depths_mm[1]), *_STEPS))
        if first > 0.0:
            return np.geomspace(first, last, count + 1)
        return np.linspace(first, last, count + 1)

    def _rate(self, share: Array, worn_mm: Array) -> Array:
        """Share of life per cycle (c, z) of logarithms (c, d); zero of what is worn off."""
        return self._rate_at(share, self.levels_mm - worn_mm[:, None])

    def _rate_at(self, share: Array, depth: Array) -> Array:
        """Share of life per cycle (c, k) at depths (c, k) below the worn surface in mm; zero beside those that are
        known.
        """
        upper = np.clip(np.searchsorted(self.depths_mm, depth, side="right") - 1, 0, len(self.depths_mm) - 2)
        above, below = self.depths_mm[upper], self.depths_mm[upper + 1]
        part = np.clip((depth - above) / (below - above), 0.0, None)
        there = np.take_along_axis(share, upper, axis=1)
        logarithm = there + part * (np.take_along_axis(share, upper + 1, axis=1) - there)
        known = (depth > -1e-12) & (part <= 1.0 + 1e-9) & (logarithm > FLOOR)
        return np.where(known, 10.0 ** np.where(known, logarithm, 0.0), 0.0)


def _between(rates: Sequence[Rates], cycle: float) -> Array:
    """Logarithms (c, d) at a cycle between states, or of the nearest one."""
    later = next((k for k, one in enumerate(rates) if one.cycle >= cycle), len(rates))
    if later in (0, len(rates)):
        return rates[min(later, len(rates) - 1)].share
    before, after = rates[later - 1], rates[later]
    part = np.log(cycle / before.cycle) / np.log(after.cycle / before.cycle)
    return np.asarray((1.0 - part) * before.share + part * after.share)
