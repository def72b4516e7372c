"""What a record can and cannot support, in plain words."""

from dataclasses import dataclass

from wirewear.base.quantity import counted
from wirewear.records.remarks import CheckedRecord, plural
from wirewear.records.values import AnyRecord

#: Samples on half of a micro-slip branch from which on its stiffness is well resolved.
RESOLVED = 4


@dataclass(frozen=True)
class Support:
    """Sentences about what can be concluded from a record, and what cannot."""

    supports: tuple[str, ...]
    cannot: tuple[str, ...]


def support(checked: CheckedRecord, spoilt: bool) -> Support:
    """Judge a record by what it holds."""
    record = checked.record
    verdicts = [*_loops(checked), *_repeats(record), *_channels(record), *_wear(record), *_model(record)]
    if spoilt:
        verdicts.append(
            (False, "Conclusions that rest on what the problems above concern, until these are cleared up.")
        )
    return Support(tuple(t for yes, t in verdicts if yes), tuple(t for yes, t in verdicts if not yes))


def _loops(checked: CheckedRecord) -> list[tuple[bool, str]]:
    figures = tuple(checked.figures.values())
    if not figures:
        return [(False, "Anything about loops: none of those looked at can be analysed.")]
    verdicts: list[tuple[bool, str]] = []
    which = "the logged cycles"
    cycles = sorted({loop.cycle for loop in checked.record.loops})
    if checked.refused:
        # Where some are refused, what was not looked at supports nothing.
        looked = len(figures) + len(checked.refused)
        among = "" if looked == len(checked.record.loops) else " looked at"
        which = f"{len(figures)} of {plural(looked, 'logged loop')}{among}"
        cycles = sorted({cycle for _, cycle in checked.figures})
    verdicts.append((True, f"Slip amplitude, dissipated energy and friction of {which}."))
    if len(cycles) > 1:
        span = f"{plural(len(cycles), 'cycle')} from {counted(cycles[0])} to {counted(cycles[-1])}"
        verdicts.append((True, f"How loops change with the cycles ({span})."))
    else:
        text = (
            "How anything changes with the cycles: there are loops of one only; roughness, wear and drift look alike. "
            "Log loops at 1, 10, 100, ... and the last cycle."
        )
        verdicts.append((False, text))
    branches = [branch for item in figures for branch in item.branches]
    few = sum(len(branch.samples) < RESOLVED for branch in branches)
    if any(item.regime == "partial slip" for item in figures):
        verdicts.append(
            (False, "The coefficient of friction where loops are in partial slip: the largest Q/P is a lower bound.")
        )
    if few > len(branches) // 2:
        text = (
            "The stiffness just after a reversal: most branches have fewer than four samples there, so that free play "
            "and compliance may look alike. Sample faster, or press on the holder with a dial gauge at it."
        )
        verdicts.append((False, text))
    elif 2 * sum(item.measured_stiffness_N_per_um is None for item in figures) > len(figures):
        verdicts.append((False, "The tangential stiffness: behind reversals, most loops show no line."))
    else:
        verdicts.append((True, "The measured tangential stiffness, rig and contact together."))
    return verdicts


def _repeats(record: AnyRecord) -> list[tuple[bool, str]]:
    count = len(record.repeats)
    if count == 1:
        text = (
            "Whether a difference means anything: with one repeat, the scatter between tests is unknown, and the "
            "sensors' noise is only a lower bound. Repeat the test with fresh specimens, or state what is known in "
            "[scatter]."
        )
        return [(False, text)]
    # 95 % interval of a standard deviation from n samples: s·sqrt((n-1)/χ²).
    factors = {2: "0.45 to 32", 3: "0.52 to 6.3", 4: "0.57 to 3.7", 5: "0.60 to 2.9"}
    known = f"; its standard deviation is known within factors of {factors[count]} only" if count in factors else ""
    return [(True, f"Scatter between tests, from {plural(count, 'repeat')}{known}.")]


def _channels(record: AnyRecord) -> list[tuple[bool, str]]:
    if any(loop.normal_force_N is not None for loop in record.loops):
        return [(True, "Telling a wrong or drifting normal load from a change of friction.")]
    text = (
        "Telling a wrong or drifting normal load from a change of friction: the normal force was not measured. A load "
        "cell under the body at rest tells it."
    )
    return [(False, text)]


def _wear(record: AnyRecord) -> list[tuple[bool, str]]:
    worn = record.tables.worn
    present = [body for body in record.tables.bodies if record.scars_of(body)]
    absent = [body for body in record.tables.bodies if body not in present]
    verdicts = [(True, worn.support.format(" and ".join(present)))] if len(present) >= worn.fewest else []
    if absent:
        verdicts.append((False, worn.lacking.format(" and the ".join(absent))))
    if record.evolution:
        verdicts.append((True, "The course of amplitudes, force and energy between the logged loops."))
    else:
        text = (
            "The course of amplitudes, force and energy between the logged loops: there is no evolution. Many loggers "
            "write such figures for every cycle ([evolution] of a mapping)."
        )
        verdicts.append((False, text))
    return verdicts


def _model(record: AnyRecord) -> list[tuple[bool, str]]:
    if absent := record.tables.missing:
        text = (
            f"A simulation from the record alone: [stated] does not give {' and '.join(absent)}. `wirewear fit RECORD` "
            "finds friction and rig stiffness from the loops, and the wear coefficient from scars and energy."
        )
        return [(False, text)]
    text = f"A simulation from the record alone, with all that is not stated taken as ideal{record.tables.assumed}."
    return [(True, text)]
