from dataclasses import dataclass

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, beyond, loaded, place_in_stroke


@dataclass(frozen=True)
class TouchingStop(Reading):
    """The arm of the load comes to touch a stop before one end of the stroke, which bears a part of the load.

    P (1 − s max(δ/A − b, 0)/(1 − b)), both ways; a negative share puts the stop at the low end.
    """

    seam = "loading"
    sets = (("reserved", 8),)

    share: float
    begins: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.01, 0.1) * d.sign(), "begins": d.random.uniform(0.2, 0.6)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        borne: Array = abs(self.share) * beyond(place, self.share, self.begins)
        return loaded(signals, 1.0 - borne)
