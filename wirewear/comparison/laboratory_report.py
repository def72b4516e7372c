"""What the report of a fretting test states: figures with their uncertainties, conditions, deviations, inputs.

The items are those that ASTM G204 (scope, introduction, 5.7) and ASTM E2789 (4.1, 4.2) name; of both standards no more
could be read, so that their own lists of what to report, and the conditions that G204 prescribes, are not among them.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from math import inf, isfinite, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.base.cache import code_hash
from wirewear.base.frame import figure
from wirewear.base.words import counted
from wirewear.comparison.budget import Budget, Contribution, of_gain, of_repeats
from wirewear.comparison.mapped_tests import MappedTest, fretting_test
from wirewear.diagnosis.infer.covariance import SCATTER
from wirewear.loops import LoopError, LoopFigures
from wirewear.records import AnyRecord
from wirewear.records.evolution_checks import accumulated_energy_J, energy_per_cycle
from wirewear.records.spikes import noise_um
from wirewear.records.values import MeasuredLoop
from wirewear.results.scar import called
from wirewear.test.conditions import held_keys

#: Channels whose calibration may be stated, as relative standard uncertainties of their gains.
CHANNELS = ("displacement", "tangential_force", "normal_force", "depth", "lateral")

AMPLITUDES_um = (10.0, 300.0)  #: The usual range of fretting motions, by the introduction of ASTM G204.
ROOM_C = (15.0, 30.0)  #: Temperatures that count as those of a room.
NOT_STATED = "not stated"

UNREAD = (
    "Of ASTM G204 its scope, introduction and section 5.7 were at hand, of ASTM E2789 its sections 4.1 and 4.2. "
    "Whether load, frequency, cycles and sphere are as G204 prescribes (sections 6 to 8) has to be checked there."
)

_BY_EXPERIENCE = "by experience with other tests"
_STATED = "as the record states"


@dataclass(frozen=True)
class Item:
    """One item of the report: its name, the standards that ask for it, and what is reported."""

    name: str
    asked_by: str
    text: str

    @property
    def known(self) -> bool:
        return not self.text.startswith(NOT_STATED)


@dataclass(frozen=True, eq=False)
class LaboratoryReport:
    """Report of one test. deviations: from ASTM G204, one sentence each. hashes: SHA-256 of input files by name.
    loops: first and last one that can be analysed, with their figures.
    """

    record: AnyRecord
    test: MappedTest
    items: tuple[Item, ...]
    budgets: tuple[Budget, ...]
    deviations: tuple[str, ...]
    rationale: str
    hashes: Mapping[str, str]
    program: Mapping[str, str]
    loops: tuple[MeasuredLoop, ...]

    def to_json(self) -> dict[str, object]:
        """Plain values: items, figures with their budgets, deviations, hashes."""
        return {
            "test": self.record.name,
            "items": [vars(item) for item in self.items],
            "figures": [
                {
                    "name": one.name,
                    "value": one.value,
                    "unit": one.unit,
                    "combined_standard_uncertainty": one.combined,
                    "effective_degrees_of_freedom": one.freedom,
                    "coverage_factor": one.coverage,
                    "expanded_uncertainty": one.expanded,
                    "contributions": [{**vars(part), "share": part.share} for part in one.contributions],
                }
                for one in self.budgets
            ],
            "deviations": list(self.deviations),
            "rationale": self.rationale,
            "inputs_sha256": dict(self.hashes),
            "program": dict(self.program),
        }


def laboratory_report(
    record: AnyRecord, path: Path, calibration: Mapping[str, float] | None = None, rationale: str = ""
) -> LaboratoryReport:
    """The report of a record, or of a simulation that was made one, which was read from a file or folder. calibration:
    relative standard uncertainties of gains by the names in CHANNELS. rationale: why the test deviates from G204.

    Raises RecordError if none of its loops can be analysed.
    """
    known = dict(calibration or {})
    test, load = fretting_test(record, path), record.tables.conditions.normal_load_N
    figures = [*_analysed(record, load)]
    budgets = (*_of_loops(record, figures, known), *_of_volumes(record, known), *_of_energy(record, figures, known))
    whole = (*budgets, *_of_wear_coefficient(budgets))
    return LaboratoryReport(
        record,
        test,
        tuple(_items(record, test, whole)),
        whole,
        tuple(_deviations(record, test, figures)),
        rationale,
        _hashes(path),
        {"wirewear": version("wirewear"), "sources_sha256": code_hash()},
        tuple(dict.fromkeys((figures[0][0], figures[-1][0]))),
    )


def _analysed(record: AnyRecord, load_N: float) -> Iterator[tuple[MeasuredLoop, LoopFigures]]:
    for loop in record.loops:
        try:
            yield loop, loop.figures(load_N)
        except LoopError:
            continue


def _hashes(path: Path) -> dict[str, str]:
    files = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
    home = path if path.is_dir() else path.parent
    visible = (one for one in files if not one.name.startswith("."))
    return {one.relative_to(home).as_posix(): hashlib.sha256(one.read_bytes()).hexdigest() for one in visible}


def _scatter(record: AnyRecord, name: str) -> tuple[float, str]:
    stated = getattr(record.tables.scatter, name, None)
    return (SCATTER[name], _BY_EXPERIENCE) if stated is None else (stated, _STATED)


def _of_loops(
    record: AnyRecord, figures: Sequence[tuple[MeasuredLoop, LoopFigures]], known: Mapping[str, float]
) -> Iterator[Budget]:
    """Friction, slip amplitude and displacement amplitude: means over the test of all repeats."""
    rows: tuple[tuple[str, str, str, str, str, dict[str, float]], ...] = (
        ("coefficient of friction", "µ", "1", "friction_geometry_independent", "friction",
         {"tangential_force": 1.0, "normal_force": -1.0}),
        ("slip amplitude", "δ0", "µm", "slip_amplitude_um", "amplitude", {"displacement": 1.0}),
        ("displacement amplitude", "δa", "µm", "displacement_amplitude_um", "amplitude", {"displacement": 1.0}),
    )  # fmt: skip
    for name, symbol, unit, key, scatter, gains in rows:
        found = [(loop, one) for loop, own in figures if (one := getattr(own, key)) is not None]
        if not found:
            continue
        repeats = sorted({loop.repeat for loop, _ in found})
        values = [float(np.mean([one.value for loop, one in found if loop.repeat == repeat])) for repeat in repeats]
        value = float(np.mean(values))
        reading = float(np.mean([one.deviation for _, one in found]))
        parts = [
            of_repeats(values, unit, *_scatter(record, scatter)),
            Contribution("reading of a loop", "B", value, unit, "normal", reading, 1.0,
                         how="fit and noise of a loop, taken as common to all"),
        ]  # fmt: skip
        yield Budget(name, symbol, value, unit, (*parts, *_gains(gains, value, known)))


def _gains(powers: Mapping[str, float], value: float, known: Mapping[str, float]) -> Iterator[Contribution]:
    """Calibrations of the channels that a figure goes with, each with the power by which it does."""
    for channel, power in powers.items():
        yield of_gain(channel.replace("_", " "), known.get(channel, 0.0), power * value)


def _of_volumes(record: AnyRecord, known: Mapping[str, float]) -> Iterator[Budget]:
    """Worn volumes of each body, and of both together where all bodies have been measured."""
    measured = record.worn_volumes_mm3
    bodies = [(called(body), (body,)) for body in record.tables.body_names if measured[body]]
    if len(bodies) > 1:
        bodies.append(("both bodies", tuple(record.tables.body_names)))
    for name, own in bodies:
        repeats = sorted(set.intersection(*(set(measured[body]) for body in own)))
        if not repeats:
            continue
        values = [sum(measured[body][repeat] for body in own) for repeat in repeats]
        value, count = float(np.mean(values)), len(values)
        maps = [one for body in own for one in record.scars_of(body) if one.repeat in repeats]
        noise, level = (float(np.linalg.norm([of(record, one) for one in maps])) / count for of in (_noise, _level))
        lateral = 2.0 if hasattr(maps[0], "y_um") else 1.0
        parts = (
            of_repeats(values, "mm³", *_scatter(record, "wear")),
            Contribution("level of what is not worn", "B", 0.0, "mm³", "normal", level, 1.0, how="border of the maps"),
            Contribution("noise of depths", "B", 0.0, "mm³", "normal", noise, 1.0, how="neighbouring points"),
            *_gains({"depth": 1.0, "lateral": lateral}, value, known),
        )
        yield Budget(f"worn volume, {name}", "V", value, "mm³", parts)


def _noise(record: AnyRecord, surface: Any) -> float:
    """Standard uncertainty of a worn volume in mm³ by independent noise of its depths."""
    depth = np.asarray(surface.depth_um)
    deviation = noise_um(depth if depth.ndim > 1 else depth[:, None])
    x = np.asarray(surface.x_um)
    step = float(np.ptp(x)) / max(x.size - 1, 1)
    inside = int(np.count_nonzero(depth > 0.01 * float(np.nanmax(depth))))
    if hasattr(surface, "y_um"):
        y = np.asarray(surface.y_um)
        return 1e-9 * deviation * sqrt(inside) * step * float(np.ptp(y)) / max(y.size - 1, 1)
    return 1e-6 * deviation * sqrt(inside) * step / float(record.tables.extent.share)


def _level(_record: AnyRecord, surface: Any) -> float:
    return float(getattr(surface, "doubt_mm3", 0.0)) / 1.96


def _of_energy(
    record: AnyRecord, figures: Sequence[tuple[MeasuredLoop, LoopFigures]], known: Mapping[str, float]
) -> Iterator[Budget]:
    """Friction energy of the whole test, mean of the repeats."""
    repeats = sorted({loop.repeat for loop in record.loops} | {part.repeat for part in record.evolution})
    found = {repeat: one for repeat in repeats if (one := accumulated_energy_J(record, repeat)) is not None}
    if not found:
        return
    value = float(np.mean([*found.values()]))
    each = [own.dissipated_energy_mJ for _, own in figures if own.dissipated_energy_mJ.value > 0.0]
    reading = float(np.mean([one.deviation / one.value for one in each])) if each else 0.0
    between = float(np.mean([abs(_by_lines(record, repeat) - one) for repeat, one in found.items()]))
    parts = (
        of_repeats([*found.values()], "J", *_scatter(record, "friction")),
        Contribution("reading of a loop's area", "B", 1.0, "1", "normal", reading, value,
                     how="noise, lag and drift of a loop, taken as common to all"),
        Contribution("cycles between logged ones", "B", 0.0, "J", "rectangular", between / sqrt(3.0), 1.0,
                     how="straight lines in place of powers of the cycle"),
        *_gains({"displacement": 1.0, "tangential_force": 1.0}, value, known),
    )  # fmt: skip
    yield Budget("friction energy of the test", "ΣE_d", value, "J", parts)


def _by_lines(record: AnyRecord, repeat: int) -> float:
    """Friction energy in J of a repeat whose energy per cycle runs along straight lines between logged cycles."""
    cycles, energies = energy_per_cycle(record, repeat)
    ends = record.working_cycles(np.append(cycles, max(record.tables.conditions.cycles, cycles[-1])))
    held = np.append(energies, energies[-1])
    return 1e-3 * float(held[0] * ends[0] + np.trapezoid(held, ends))


def _of_wear_coefficient(budgets: Sequence[Budget]) -> Iterator[Budget]:
    known = {one.name: one for one in budgets}
    volume, energy = known.get("worn volume, both bodies"), known.get("friction energy of the test")
    if volume is None or energy is None or not energy.value:
        return
    value = volume.value / energy.value
    parts = (
        Contribution("worn volume, both bodies", "B", volume.value, "mm³", "t", volume.combined,
                     1.0 / energy.value, volume.freedom, "its own budget"),
        Contribution("friction energy", "B", energy.value, "J", "t", energy.combined,
                     -value / energy.value, energy.freedom, "its own budget"),
    )  # fmt: skip
    yield Budget("energy wear coefficient", "α", value, "mm³/J", parts)


def _items(record: AnyRecord, test: MappedTest, budgets: Sequence[Budget]) -> Iterator[Item]:
    tables = record.tables
    asked, facts = tables.conditions, tables.metadata
    g204, e2789 = "G204 1.2", "E2789 4.1"

    def said(value: object, unit: str = "") -> str:
        return NOT_STATED if value is None else f"{value:g}{unit}" if isinstance(value, float) else f"{value}{unit}"

    found = {one.name: one for one in budgets}

    def measured(*names: str) -> str:
        shown = [f"{_text(found[name])}" for name in names if name in found]
        return "; ".join(shown) if shown else NOT_STATED

    yield Item("contact", f"{g204}, {e2789}", f"{tables.contact_kind}; " + "; ".join(_bodies(tables)))
    yield Item("materials", f"G204 5.6, {e2789}", "; ".join(_materials(tables)) or NOT_STATED)
    yield Item("hardness", "E2789 4.2", said(facts.hardness_HV, " HV"))
    yield Item("finish", e2789, said(facts.roughness_Ra_um, " µm Ra"))
    yield Item("normal load", f"{g204}, {e2789}", said(float(asked.normal_load_N), " N"))
    held = ", ".join(held_keys(asked)) or f"displacement amplitude, {asked.drive}"
    yield Item("displacement amplitude", e2789, f"{said(asked.displacement_amplitude_um, ' µm')} asked; held: {held}")
    forces = [float(np.nanmax(np.abs(loop.tangential_force_N))) for loop in record.loops]
    yield Item("tangential force", e2789, f"±{max(forces):.3g} N at most" if forces else NOT_STATED)
    yield Item("frequency", "E2789 4.2", said(float(asked.frequency_Hz), " Hz"))
    yield Item("cycles", "E2789 4.2", counted(asked.cycles))
    yield Item("number of tests", "E2789 4.2", str(max(len({loop.repeat for loop in record.loops}), 1)))
    stiffness = getattr(tables.stated, "tangential_stiffness_N_per_mm", None)
    unit = "" if stiffness == "rigid" else " N/mm of the rig"
    yield Item("compliance of the test system", "E2789 4.2", said(stiffness, unit))
    yield Item("environment", f"{g204}, {e2789}", _environment(facts))
    yield Item("lubricant", g204, said(facts.lubricant))
    yield Item("volume loss of each body", "G204 1.3", measured(*(n for n in found if n.startswith("worn volume"))))
    yield Item("friction", "E2789 4.2", measured("coefficient of friction"))
    yield Item("friction energy", "E2789 4.2", measured("friction energy of the test"))
    yield Item("regime of slip", "G204 introduction", test.regime)
    yield Item("cracks", "E2789 4.1", said(facts.cracks))
    yield Item("analytical procedures", "E2789 4.2", "figures as docs/loops.md defines them; volumes of levelled maps")
    who = ", ".join(filter(None, (facts.laboratory, facts.date)))
    yield Item("laboratory and date", "E2789 4.2", who or NOT_STATED)
    yield Item("origin of the data", "E2789 4.2", said(facts.source))


def _text(budget: Budget) -> str:
    name = budget.name.removeprefix("worn volume, ")
    return f"{name} {figure(budget.value)} ± {figure(budget.expanded, 2)} {budget.unit}".removesuffix(" 1")


def _bodies(tables: Any) -> Iterator[str]:
    for name in tables.body_names:
        sizes = {key: value for key, value in _facts(tables, name).items() if key.endswith("_mm")}
        known = [f"{key} = {v:g}" for key, v in sizes.items() if isinstance(v, float | int) and v and isfinite(v)]
        yield f"{called(name)} {', '.join(known) or 'without curvature'}"
    angle = getattr(getattr(tables, "wires", None), "crossing_angle_deg", None)
    if angle is not None:
        yield f"crossing angle {angle:g}°"


def _facts(tables: Any, name: str) -> dict[str, Any]:
    """What is known of a body, by key."""
    bodies = {body.name: body for body in getattr(tables, "bodies_of_test", ())}
    return dict(vars(bodies[name] if name in bodies else getattr(tables, name)))


def _materials(tables: Any) -> Iterator[str]:
    for name in tables.body_names:
        body = _facts(tables, name)
        stated = [f"E = {body['youngs_modulus_MPa']:g} MPa, ν = {body['poissons_ratio']:g}"]
        yield f"{called(name)}: {', '.join(filter(None, [body.get('material'), *stated]))}"


def _environment(facts: Any) -> str:
    known = {
        "atmosphere": facts.atmosphere,
        "temperature": None if facts.temperature_C is None else f"{facts.temperature_C:g} °C",
        "relative humidity": None
        if facts.relative_humidity_percent is None
        else f"{facts.relative_humidity_percent:g} %",
    }
    lacking = [name for name, value in known.items() if value is None]
    said = ", ".join(f"{name} {value}" for name, value in known.items() if value is not None)
    rest = f" ({', '.join(lacking)} {NOT_STATED})" if said and lacking else ""
    return f"{said or NOT_STATED}{rest}"


def _deviations(
    record: AnyRecord, test: MappedTest, figures: Sequence[tuple[MeasuredLoop, LoopFigures]]
) -> Iterator[str]:
    """Where the test is another one than ASTM G204 describes."""
    if not _sphere_on_flat(record.tables):
        yield f"The contact is {record.tables.contact_kind}; G204 asks for a hemispherical rider on a flat (1.2)."
    yield from _of_surroundings(record.tables.metadata)
    amplitude = test.displacement_amplitude_um
    if isfinite(amplitude) and not AMPLITUDES_um[0] <= amplitude <= AMPLITUDES_um[1]:
        yield f"The amplitude is {amplitude:.3g} µm; fretting is usually 10 to 300 µm (introduction)."
    if test.regime != "gross slip":
        yield f"The test is in {test.regime}; without gross slip damage may fail to appear (introduction)."
    loads = [loop.normal_force_N for loop, _ in figures if loop.normal_force_N is not None]
    if any(np.ptp(np.percentile(load, (5.0, 95.0))) > 0.1 * np.mean(load) for load in loads):
        yield "The normal load varies by more than a tenth within a cycle; G204 loads by a mass (1.2)."
    lacking = [called(body) for body, volumes in record.worn_volumes_mm3.items() if not volumes]
    if lacking:
        yield f"No volume loss of {' and '.join(lacking)} was measured; G204 asks for that of both surfaces (1.3)."


def _sphere_on_flat(tables: Any) -> bool:
    """True if one body has the same diameter both ways and the other has none."""
    diameters = [body.diameters_mm for body in getattr(tables, "bodies_of_test", ())]
    return sorted(map(min, diameters))[1:] == [inf] and all(along == across for along, across in diameters)


def _of_surroundings(facts: Any) -> Iterator[str]:
    if facts.lubricant is not None and facts.lubricant.casefold() not in ("none", "dry"):
        yield f"The contact is lubricated ({facts.lubricant}); G204 is intended for air (1.2)."
    if facts.atmosphere is not None and "air" not in facts.atmosphere.casefold():
        yield f"The atmosphere is {facts.atmosphere}; G204 is intended for air (1.2)."
    if facts.temperature_C is None:
        yield "The temperature is not stated; G204 is intended for that of a room (1.2)."
    elif not ROOM_C[0] <= facts.temperature_C <= ROOM_C[1]:
        yield f"The temperature is {facts.temperature_C:g} °C; G204 is intended for that of a room (1.2)."
