"""The nominal model of a line contact's record, and its one run, kept for records that state the same."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wirewear.base.errors import RecordError
from wirewear.base.identity import PLANAR_CODE, Identity, added_code, identity_of
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.nominal import SAME, half_decades, kept_or_made

if TYPE_CHECKING:
    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.planar.tables import PlanarStudy
    from wirewear.records import LineRecord
    from wirewear.results import RunResult

_KNOWN = constants("model.line_nominal")

#: The run wears so many times as fast as stated, so that other wear only re-labels its cycles; and how coarsely it
#: jumps, which moves depths by a thousandth.
WEAR_MARGIN, JUMP_TOLERANCE = _KNOWN.each("wear_margin", "jump_tolerance")


def checked_line_model(record: LineRecord, study: PlanarStudy) -> PlanarStudy:
    """A study that is to be diagnosed against a line contact's record.

    Raises:
        RecordError: it has variants, or is of another face, load or amplitude than the record's test.
    """
    if study.variant_names:
        names = ", ".join(study.variant_names)
        raise RecordError(f"the model {study.name!r} has variants ({names}): give a study of one of them.")
    believed, asked, length = study.conditions, record.tables.conditions, record.tables.contact.length_mm
    pairs = {
        "the normal load per mm": (believed.normal_load_N_per_mm, asked.normal_load_N / length),
        "displacement_amplitude_um": (believed.displacement_amplitude_um, asked.displacement_amplitude_um),
        "cycles": (believed.cycles, asked.cycles),
    }
    for key in ("radius_mm", "face_half_width_mm", "edge_radius_mm"):
        own, recorded = getattr(study.pad, key), getattr(record.tables.pad, key, None)
        if own is not None or recorded is not None:
            pairs[key] = (own or 0.0, recorded or 0.0)
    for key, (own, recorded) in pairs.items():
        if abs(own - recorded) > SAME * max(abs(own), abs(recorded)):
            raise RecordError(
                f"{key} is {own:g} in the model {study.name!r} but {recorded:g} in the record {record.name!r}: they "
                "must describe the same test."
            )
    return study


def nominal_line_run(study: PlanarStudy, observer_of: ObserverOf | None = None) -> RunResult:
    """The quick run of a study, from the cache or made now; it wears faster than stated by a margin.

    Raises:
        StudyError: the study cannot be meshed.
        SolverError: the contact did not converge.
    """
    from wirewear.planar.run import run_planar_variants
    from wirewear.results import read_result

    # Effects of the model enter the fast model; the wear states are those without.
    study = _faster_wearing(study.model_copy(update={"effects": ()}))

    def made(folder: Path) -> tuple[RunResult, Path]:
        result = run_planar_variants(study, fidelity="quick", output=folder, observer_of=observer_of)[0]
        return result, folder / "result.h5"

    return kept_or_made(f"nominal-line-{_identity(study).name}.h5", read_result, made)[0]


def _faster_wearing(study: PlanarStudy) -> PlanarStudy:
    cycles = study.conditions.cycles
    wear = {name: WEAR_MARGIN * value for name, value in study.wear.model_dump().items()}
    tolerance = study.mesh.jump_tolerance or JUMP_TOLERANCE
    return study.model_copy(
        update={
            "wear": study.wear.model_copy(update=wear),
            "log": study.log.model_copy(update={"loop_cycles": tuple(sorted({*half_decades(cycles), cycles}))}),
            "mesh": study.mesh.model_copy(update={"jump_tolerance": tolerance}),
        }
    )


def _identity(study: PlanarStudy) -> Identity:
    stated: dict[str, Any] = study.model_dump(mode="json", exclude_none=True)
    asked = {key: value for key, value in stated.items() if key not in ("name", "effects")}
    # Without inertia loops are the same at any frequency; times are not read.
    asked["conditions"] = {**stated["conditions"], "frequency_Hz": 1.0, "motion": "sinusoidal"}
    plan: dict[str, Any] = {"added": added_code((study.contact.friction_law,))}
    return identity_of(asked, (*PLANAR_CODE, "wirewear/diagnosis/model/line_nominal.py"), plan)
