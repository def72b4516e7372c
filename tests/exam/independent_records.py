"""Records of the steel wires by the independent forward model: nothing of it is the diagnosis' own.

Its friction law is Dahl's, its contact an elastic foundation, so that its loops differ from the program's as another
solver's do.
"""

from collections.abc import Mapping

from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.waveform import Waveform
from tests.diagnosis.diagnosis_cases import CYCLES, EVOLUTION_CYCLES
from wirewear.records import ExperimentRecord

POINTS = 12  #: Points of its grid to each side of the contact: half of what blind records have.


def independent_record(
    effects: Mapping[str, Mapping[str, float]] | None = None,
    *,
    repeats: int = 3,
    seed: int = 1,
    samples: int = 256,
    drive: str = "sensor",
    normal: bool = True,
    evolution: bool = True,
    scars: bool = False,
) -> ExperimentRecord:
    """What a rig of that model logs of the article's test, with these effects in it that its owner does not know of."""
    nuisances = Nuisances(
        repeats=repeats, scatter=Scatter(friction=0.01, load=0.004, wear=0.04, angle_deg=0.2),
        displacement_noise_um=0.15, force_noise_N=0.008, correlation=0.0, outlier_share=0.0,
        waveform=Waveform(0.0, 0.0), amplitude_drift=0.0, drive=drive, samples=samples, has_normal_force=normal,
        has_evolution=evolution, has_scars=scars, loop_cycles=(CYCLES,) * repeats, evolution_cycles=EVOLUTION_CYCLES,
    )  # fmt: skip
    truth = tuple(TrueEffect(name, dict(parameters)) for name, parameters in (effects or {}).items())
    case = Case("made for a test", "single" if truth else "none", None, truth, (), Nominal(), nuisances, seed)
    made = IndependentModel("dahl", POINTS).make(case).record
    assert isinstance(made, ExperimentRecord)
    return made
