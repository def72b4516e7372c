from dataclasses import dataclass

from studies.blind.causes.cause import FrictionFactor, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class ChangingAir(FrictionFactor):
    """Humidity changes at three moments, and friction with it (Goto & Buckley, Tribology Int. 18 (1985) 237)."""

    seam = "contact"
    sets = (("withheld", 14),)

    factor_1: float
    factor_2: float
    factor_3: float
    cycle_1: float
    cycle_2: float
    cycle_3: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # Some hours or days apart; the middle one is back beyond the first state.
        size, sign = d.between(0.025, 0.2), d.sign()
        factors = (1.0 + size * sign, 1.0 - size * sign * d.random.uniform(0.2, 0.8), 1.0 + size * sign)
        moments = (d.spread(0.02, 0.08), d.spread(0.12, 0.25), d.spread(0.4, 0.8))
        cycles = d.nominal.cycles
        return {
            **{f"factor_{i}": factor for i, factor in enumerate(factors, start=1)},
            **{f"cycle_{i}": cycles * part for i, part in enumerate(moments, start=1)},
        }

    def at(self, cycle: float) -> float:
        taken = ((self.cycle_3, self.factor_3), (self.cycle_2, self.factor_2), (self.cycle_1, self.factor_1))
        return next((factor for start, factor in taken if cycle >= start), 1.0)
