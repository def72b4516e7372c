"""Tests of line contacts as a fit sees them: of the whole contact, while studies are of a millimetre of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.diagnosis.model.candidates import nominal_line_setup
from wirewear.diagnosis.model.line_nominal import nominal_line_run
from wirewear.diagnosis.model.line_states import LineStates
from wirewear.fitting.fast_fit import figures_of_model
from wirewear.fitting.loops_of_tests import FITTED
from wirewear.fitting.subject import ANY_WEAR_mm3_per_J, Volumes, Worn
from wirewear.fitting.values import FittedParameter
from wirewear.planar.reading import planar_study_from_tables
from wirewear.records import LineRecord
from wirewear.records.exporting import true_loop
from wirewear.records.line_believed import stated_wear, tables_of_test
from wirewear.results import BODIES

if TYPE_CHECKING:
    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.planar.tables import PlanarStudy
    from wirewear.records.values import MeasuredLoop
    from wirewear.results import RunResult

#: Cycles of the run on a rigid rig that tells the stiffness of the contact and its bodies.
_FIRST_CYCLES = 10


@dataclass(frozen=True, eq=False)
class LineTestFit:
    """A test of a line contact; see `Subject`."""

    record: LineRecord
    #: Stiffer than what a record may state.
    rigid_N_per_mm: float = 1e7
    where_volumes: str = "measure both profiles ([profiles.pad] and [profiles.specimen] of the mapping)"

    def worn(self, volumes: Volumes, energies_J: Mapping[int, float]) -> Worn:
        """A coefficient for each body that a profile is known of."""
        fitted, notes = {}, []
        for body in BODIES:
            repeats = sorted(set(energies_J) & set(volumes[body]))
            if repeats:
                own = [volumes[body][repeat] / energies_J[repeat] for repeat in repeats]
                fitted[_coefficient(body)] = FittedParameter.of_repeats(own, "mm3_per_J")
        if len(fitted) == 1:
            (missing,) = (body for body in BODIES if _coefficient(body) not in fitted)
            wears = "wears as stated" if missing in (self.stated_wear() or "") else "does not wear in the study"
            notes.append(f"no profile of the {missing} is known, which {wears}; measure it, too")
        return fitted, notes

    def parted(self, total: FittedParameter) -> Worn:
        """In the proportion that the record states, or evenly."""
        stated = [self._stated(body) or 0.0 for body in BODIES]
        shares = [own / sum(stated) for own in stated] if sum(stated) > 0.0 else [0.5, 0.5]
        low, high = total.interval95
        parts = {
            _coefficient(body): FittedParameter(
                share * total.value, (share * low, share * high), total.unit, total.repeats
            )
            for body, share in zip(BODIES, shares, strict=True)
        }
        return parts, [f"it is parted between pad and specimen as {shares[0]:.2g} to {shares[1]:.2g}"]

    def total_of(self, parameters: Mapping[str, FittedParameter]) -> float | None:
        """The sum of the bodies'."""
        known = [parameters[key].value for key in map(_coefficient, BODIES) if key in parameters]
        return sum(known) if known else None

    def stated_wear(self) -> str | None:
        """Each body's coefficient."""
        known = stated_wear(self.record.tables.stated)
        units = {"J": "mm³/J", "m": "mm³/(N·m)"}
        words = (f"{value:.3g} {units[key[-1]]} of the {key.partition('_')[0]}" for key, value in known.items())
        return " and ".join(words) or None

    def contact_stiffness_N_per_um(self, friction: float) -> float:
        """Of loops on a rigid rig: the bodies as a whole give way, and no closed form tells by how much."""
        rigid_rig = dict.fromkeys(("tangential_stiffness_N_per_mm", "rotational_stiffness_N_mm_per_rad"), "rigid")
        study = self.study({"friction": friction, **rigid_rig, **self._some_wear()}, [], [1])
        conditions = study.conditions.model_copy(update={"cycles": _FIRST_CYCLES})
        rigid = study.model_copy(update={"conditions": conditions})
        states, _ = self.states(rigid, None)
        setup = self.setup(rigid)
        found = figures_of_model(states, setup, np.array([np.log(friction), 0.0]), np.ones(1))
        measured = float(found[0, list(FITTED).index("measured_stiffness_N_per_um")])
        # A loop that hardly slides shows no straight part: the stiffness at its reversal then stands in.
        return measured if np.isfinite(measured) else float(states.stiffness_N_per_um[0])

    def rig_compliance(self, measured_N_per_um: float, contact_N_per_um: float) -> float:
        """Springs in series: the stick branch of a line contact is all but straight."""
        return max(1.0 / measured_N_per_um - 1.0 / contact_N_per_um, 0.0)

    def study(self, stated: Mapping[str, Any], effects: list[dict[str, Any]], cycles: list[int]) -> PlanarStudy:
        """As the record states it with these keys; what wears by the energy does not wear by Archard's law as well."""
        record, own = self.record, {"friction_evolution": None, **stated}
        if "tangential_stiffness_N_per_mm" in stated:
            # What is fitted is the rig's own.
            own["stiffness_includes"] = "rig only"
        for body in BODIES:
            if _coefficient(body) in stated:
                own[f"{body}_archard_wear_coefficient_mm3_per_N_m"] = None
        believed = record.tables.stated.model_copy(update=own)
        tables = record.tables.model_copy(update={"stated": believed})
        data = tables_of_test(tables, float(own["friction"]))
        all_effects = [*data.get("effects", ()), *effects]
        more = {"log": {"loop_cycles": cycles}} | ({"effects": all_effects} if all_effects else {})
        return planar_study_from_tables(data | more, f"the fit of {record.name!r}")

    def states(self, study: PlanarStudy, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Those of the nominal run."""
        result = nominal_line_run(study, observer_of)
        return LineStates.of_line(result, study.pad.profile, self.record.tables.contact.length_mm), ()

    def run(
        self, study: PlanarStudy, output: Path, fidelity: str, observer_of: ObserverOf
    ) -> tuple[RunResult, dict[int, MeasuredLoop]]:
        """Loops of the whole contact, of a run of one millimetre."""
        from wirewear.planar import run_planar_variants
        from wirewear.results import read_loops

        result = run_planar_variants(study, fidelity=fidelity, output=output, observer_of=observer_of)[0]
        whole = result.of_length(self.record.tables.contact.length_mm)
        return result, {loop.cycle: true_loop(loop) for loop in read_loops(whole)}

    def setup(self, study: PlanarStudy) -> Setup:
        """The nominal one."""
        return nominal_line_setup(study, self.record.tables.contact.length_mm, self.record.tables.conditions.drive)

    def _stated(self, body: str) -> float | None:
        value: float | None = getattr(self.record.tables.stated, _coefficient(body))
        return value

    def _some_wear(self) -> dict[str, float]:
        """Wear of steel for a test of which none is stated."""
        known = stated_wear(self.record.tables.stated)
        return {} if known else {_coefficient(body): 0.5 * ANY_WEAR_mm3_per_J for body in BODIES}


def _coefficient(body: str) -> str:
    return f"{body}_energy_wear_coefficient_mm3_per_J"
