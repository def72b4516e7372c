"""What is wrong with a line contact's record, and what it can and cannot support, in plain words."""

from collections.abc import Iterable, Iterator

from wirewear.loops import LoopFigures
from wirewear.records.checking import looked_at, loop_remarks
from wirewear.records.line_believed import assumed_heights_mm
from wirewear.records.line_values import BODIES, LineRecord, MeasuredProfile
from wirewear.records.profile_sizes import unlike_profiles
from wirewear.records.remarks import RecordReport, Remark

# A worn area may differ from what is stated by this factor before units are suspected.
_AREA = 30.0
# Share of the largest depth that may stand at the end of a profile.
_AT_END = 0.1


def check_line_record(record: LineRecord) -> RecordReport:
    """Check loops, loads, amplitudes and profiles of a record, and say what it supports."""
    remarks = [Remark("note", "experiment.toml", f"{note}.") for note in record.notes]
    checked = looked_at(record, record.tables.contact.length_mm)
    remarks += loop_remarks(checked)
    remarks += _friction_remarks(record, checked.figures.values())
    remarks += _bodies_remarks(record)
    for profile in record.profiles:
        remarks += _profile_remarks(record, profile)
    remarks += [Remark("problem", "profiles", text) for text in unlike_profiles(record)]
    supports, cannot = _support(record, bool(checked.figures))
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


def _friction_remarks(record: LineRecord, figures: Iterable[LoopFigures]) -> Iterator[Remark]:
    if record.tables.stated.friction is not None:
        known = (one.friction_max.value for one in figures if one.friction_max is not None)
        largest = max(known, default=0.0)
        if largest > 3.0 * max(record.tables.stated.friction, 0.01):
            text = f"the largest Q/P is {largest:.3g}, three times the stated friction: forces may be per millimetre."
            yield Remark("problem", "friction", text)


def _bodies_remarks(record: LineRecord) -> list[Remark]:
    """What is assumed of bodies that are not described: their compliance adds to the rig's."""
    missing = assumed_heights_mm(record.tables)
    if not missing:
        return []
    taken = " and ".join(f"the {body} is taken to be {height:.3g} mm high" for body, height in missing.items())
    text = (
        f"{taken[0].upper()}{taken[1:]} from the contact to where it is held, which gives way beside the rig: measured "
        f"stiffnesses and amplitudes depend on it; state height_mm (and half_width_mm) in "
        f"{' and '.join(f'[{body}]' for body in missing)}."
    )
    return [Remark("note", "bodies", text)]


def _profile_remarks(record: LineRecord, profile: MeasuredProfile) -> list[Remark]:
    who = f"the {profile.body}'s profile of repeat {profile.repeat}"
    deepest = float(profile.smooth_um.max())
    if deepest <= 0.0:
        return [Remark("note", "profiles", f"{who} shows no wear.")]
    found = []
    ends = max(profile.smooth_um[0], profile.smooth_um[-1])
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


def _support(record: LineRecord, analysed: bool) -> tuple[list[str], list[str]]:
    supports: list[str] = []
    cannot: list[str] = []
    (supports if analysed else cannot).append("Slip amplitude, dissipated energy and friction of the logged cycles.")
    (supports if record.evolution else cannot).append("How energies and forces change over all cycles.")
    for body in BODIES:
        (supports if record.profiles_of(body) else cannot).append(f"Depth, width and worn area of the {body}.")
    if len(record.repeats) < 2:
        cannot.append("How much tests scatter: there is one repeat.")
    return supports, cannot
