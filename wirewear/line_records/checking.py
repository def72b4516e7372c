"""What is wrong with a line contact's record, and what it can and cannot support, in plain words."""

from collections.abc import Iterator

import numpy as np

from wirewear.line_records.values import BODIES, LineRecord, MeasuredProfile
from wirewear.loops import LoopError, LoopFigures
from wirewear.planar.tables import Pad, Specimen
from wirewear.records.remarks import RecordReport, Remark

# Shares by which loads and amplitudes may differ from what was asked.
_LOAD, _AMPLITUDE = 0.2, 0.2
# A worn area may differ from what is stated by this factor before units are suspected.
_AREA = 30.0
# Share of the largest depth that may stand at the end of a profile.
_AT_END = 0.1


def check_line_record(record: LineRecord) -> RecordReport:
    """Check loops, loads, amplitudes and profiles of a record, and say what it supports."""
    remarks = [Remark("note", "experiment.toml", f"{note}.") for note in record.notes]
    figures = dict(_figures(record, remarks))
    remarks += _loop_remarks(record, figures)
    remarks += _bodies_remarks(record)
    for profile in record.profiles:
        remarks += _profile_remarks(record, profile)
    supports, cannot = _support(record, figures)
    return RecordReport(
        name=record.name,
        repeats=record.repeats,
        cycles=record.cycles,
        loops=len(record.loops),
        samples=sum(loop.time_s.size for loop in record.loops),
        remarks=tuple(remarks),
        supports=tuple(supports),
        cannot=tuple(cannot),
        metadata=record.tables.metadata.lines,
    )


def _figures(record: LineRecord, remarks: list[Remark]) -> Iterator[tuple[str, LoopFigures]]:
    for loop in record.loops:
        try:
            yield loop.name, loop.figures(record.tables.conditions.normal_load_N)
        except LoopError as error:
            remarks.append(Remark("problem", "loops", f"{loop.name} cannot be analysed: {error}"))


def _loop_remarks(record: LineRecord, figures: dict[str, LoopFigures]) -> list[Remark]:
    asked, found = record.tables.conditions, []
    for loop in record.loops:
        x, q = loop.complete.displacement_um, loop.complete.tangential_force_N
        if float(np.sum(q * (np.roll(x, -1) - np.roll(x, 1)))) < 0.0:
            text = f"{loop.name} gives energy back: the sign of its force or displacement is turned round."
            found.append(Remark("problem", "energy", text, refuses=True))
        amplitude = 0.5 * float(np.ptp(x))
        if abs(amplitude / asked.displacement_amplitude_um - 1.0) > _AMPLITUDE:
            text = f"{loop.name} moves by ±{amplitude:.3g} µm, where ±{asked.displacement_amplitude_um:.3g} were asked."
            found.append(Remark("note", "amplitude", text))
        if loop.normal_force_N is not None:
            load = float(np.nanmean(loop.normal_force_N))
            if abs(load / asked.normal_load_N - 1.0) > _LOAD:
                text = f"{loop.name} has a load of {load:.4g} N, where {asked.normal_load_N:.4g} were asked."
                found.append(Remark("problem", "load", text))
    if figures and record.tables.stated.friction is not None:
        known = (one.friction_max.value for one in figures.values() if one.friction_max is not None)
        largest = max(known, default=0.0)
        if largest > 3.0 * max(record.tables.stated.friction, 0.01):
            text = f"the largest Q/P is {largest:.3g}, three times the stated friction: forces may be per millimetre."
            found.append(Remark("problem", "friction", text))
    return found


def _bodies_remarks(record: LineRecord) -> list[Remark]:
    """What is assumed of bodies that are not described: their compliance adds to the rig's."""
    tables = record.tables
    missing = [body for body in BODIES if getattr(tables, body).height_mm is None]
    if not missing:
        return []
    heights = {"pad": Pad.model_fields["height_mm"].default, "specimen": Specimen.model_fields["height_mm"].default}
    taken = " and ".join(f"the {body} is taken to be {heights[body]:g} mm high" for body in missing)
    text = (
        f"{taken[0].upper()}{taken[1:]} from the contact to where it is held, which gives way beside the rig: measured "
        f"stiffnesses and amplitudes depend on it; state height_mm (and half_width_mm) in "
        f"{' and '.join(f'[{body}]' for body in missing)}."
    )
    return [Remark("note", "bodies", text)]


def _profile_remarks(record: LineRecord, profile: MeasuredProfile) -> list[Remark]:
    who = f"the {profile.body}'s profile of repeat {profile.repeat}"
    deepest = float(profile.depth_um.max())
    if deepest <= 0.0:
        return [Remark("note", "profiles", f"{who} shows no wear.")]
    found = []
    ends = max(profile.depth_um[0], profile.depth_um[-1])
    if ends > _AT_END * deepest:
        found.append(Remark("problem", "profiles", f"{who} ends inside the scar, {ends:.3g} µm deep."))
    expected = _expected_area(record, profile.body)
    if expected is not None and not 1.0 / _AREA < profile.area_um2 / expected < _AREA:
        text = f"{who} has lost {profile.area_um2:.3g} µm², expected {expected:.3g}: check its units."
        found.append(Remark("problem", "profiles", text))
    return found


def _expected_area(record: LineRecord, body: str) -> float | None:
    """Worn cross-section in gross slip on a rigid rig by what is stated, µm²; None where too little is."""
    stated, asked = record.tables.stated, record.tables.conditions
    energy = getattr(stated, f"{body}_energy_wear_coefficient_mm3_per_J")
    archard = getattr(stated, f"{body}_archard_wear_coefficient_mm3_per_N_m")
    sliding_N_m = 4e-6 * asked.normal_load_N * asked.displacement_amplitude_um * asked.cycles
    if archard is not None:
        volume = archard * sliding_N_m
    elif energy is not None and stated.friction is not None:
        volume = energy * stated.friction * sliding_N_m
    else:
        return None
    return 1e6 * volume / record.tables.contact.length_mm if volume > 0.0 else None


def _support(record: LineRecord, figures: dict[str, LoopFigures]) -> tuple[list[str], list[str]]:
    supports: list[str] = []
    cannot: list[str] = []
    (supports if figures else cannot).append("Slip amplitude, dissipated energy and friction of the logged cycles.")
    (supports if record.evolution else cannot).append("How energies and forces change over all cycles.")
    for body in BODIES:
        (supports if record.profiles_of(body) else cannot).append(f"Depth, width and worn area of the {body}.")
    if len(record.repeats) < 2:
        cannot.append("How much tests scatter: there is one repeat.")
    return supports, cannot
