"""Page of many tests on maps, and their table for a terminal, as JSON and as CSV."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.frame import figure, number, numbers
from wirewear.base.words import counted
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.comparison.mapped_tests import REGIMES, MappedTest, lines_of
from wirewear.comparison.maps import TRANSITION, FreshContact, RegressionLine, tension_lines, transition
from wirewear.views.run_page import HERE as REPORT

#: Rows of the table and of the CSV file of crossed wires: its heading there, here, and its digits here.
COLUMNS = (
    ("normal_load_N", "P [N]", 3),
    ("displacement_amplitude_um", "δa [µm]", 3),
    ("slip_amplitude_um", "δ0 [µm]", 3),
    ("energy_ratio", "A", 2),
    ("system_free_ratio", "B", 2),
    ("friction", "µ", 3),
    ("regime", "regime", 0),
    ("energy_J", "ΣE_d [J]", 3),
    ("volume_mm3", "V [mm³]", 3),
    ("wear_coefficient_mm3_per_J", "V/ΣE_d [mm³/J]", 3),
    ("repeats", "tests", 0),
    ("cracks", "cracks", 0),
)


#: Names and headings of columns, by what is behind their units, where they are others than those of wires.
PER: dict[str, dict[str, tuple[str, str]]] = {
    "": {},
    "/mm": {
        "normal_load_N": ("normal_load_N_per_mm", "P [N/mm]"),
        "energy_J": ("energy_J_per_mm", "ΣE_d [J/mm]"),
        "volume_mm3": ("volume_mm3_per_mm", "V [mm³/mm]"),
    },
}

HERE = Path(__file__).parent
PAGE_NAME, TABLE_NAME = "maps.html", "tests.csv"

#: How each regime is drawn: colours and shapes differ.
MARKS = dict(zip(REGIMES, (("#0072B2", "circle"), ("#E69F00", "diamond"), ("#D55E00", "square")), strict=True))
BEYOND = 6.0  #: Maps reach beyond the tests' displacements and loads by this factor.
POINTS = 41  #: Loads of a line.
NEAR = 0.06  #: Tests nearer to one another than this, relative to displacement and load, share one label.


def columns_of(tests: Sequence[MappedTest]) -> tuple[tuple[str, str, int], ...]:
    """Columns of the table as (name, heading, digits), for tests that are all of one kind of contact."""
    named = PER[tests[0].extent.per]
    return tuple((*named.get(name, (name, heading)), digits) for name, heading, digits in COLUMNS)


def row_of(test: MappedTest) -> dict[str, object]:
    """Row of one test by column name, with slip and criteria of the last cycle; None for unknown values."""
    last = test.sliding[-1]
    row = {
        "test": test.name,
        "source": test.source,
        "normal_load_N": test.normal_load_N,
        "displacement_amplitude_um": test.displacement_amplitude_um,
        "slip_amplitude_um": test.slip_amplitude_um[-1],
        "energy_ratio": last.energy_ratio,
        "system_free_ratio": last.system_free_ratio,
        "friction": test.friction,
        "regime": test.regime,
        "energy_J": test.energy_J,
        "volume_mm3": test.volume_mm3,
        "wear_coefficient_mm3_per_J": test.volume_mm3 / test.energy_J if test.energy_J > 0.0 else float("nan"),
        "repeats": test.repeats,
        "cracks": test.cracks,
    }
    named = PER[test.extent.per]
    row = {named[key][0] if key in named else key: value for key, value in row.items()}
    # NaN alone differs from itself.
    return {key: None if value != value else value for key, value in row.items()}  # noqa: PLR0124


def tests_table(tests: Sequence[MappedTest]) -> Table:
    """Table of all tests, numbered as on the page, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("", "test", "source"):
        table.add_column(heading, overflow="fold")
    columns = columns_of(tests)
    for _, heading, digits in columns:
        table.add_column(heading, justify="right" if digits else "left")
    for place, test in enumerate(tests, 1):
        row = row_of(test)
        shown = (shown_in(row[name], digits) for name, _, digits in columns)
        table.add_row(str(place), Text(test.name), test.source, *shown)
    return table


def shown_in(value: Any, digits: int) -> str:
    """A value of `row_of` as a cell of a table, with the digits of its column, 0 for a word; "–" if it is unknown."""
    return figure(value, digits) if digits else str("–" if value is None else value)


def sentences(tests: Sequence[MappedTest]) -> list[str]:
    """Summary: how many tests are in which regime, and the regression lines of worn volume over energy if there are
    any.
    """
    counts = {regime: sum(test.regime == regime for test in tests) for regime in REGIMES}
    named = [
        f"{count} in {regime}" if regime != "mixed" else f"{count} mixed" for regime, count in counts.items() if count
    ]
    said = [f"{counted(len(tests))} test{'' if len(tests) == 1 else 's'}: {', '.join(named)}."]
    through, threshold = lines_of(tests)
    if through is not None:
        said.append(f"Wear: V = {_interval(through)} · ΣE_d over {counted(through.tests)} worn specimen pairs.")
    if threshold is not None:
        low, high = threshold.threshold_interval95
        what = "no threshold differs from zero" if low <= 0.0 <= high else "the threshold differs from zero"
        unit = f"J{tests[0].extent.per}"
        energy = f"E_th {figure(threshold.threshold_J)} {unit} ({figure(low)} to {figure(high)})"
        said.append(f"With a threshold, V = {_interval(threshold)} · (ΣE_d − E_th), {energy}: {what}.")
    return said


def _interval(line: RegressionLine) -> str:
    low, high = line.slope_interval95
    within = f" ({figure(low)} to {figure(high)})" if line.tests > 1 else ""
    return f"{figure(line.slope_mm3_per_J)}{within} mm³/J"


def maps_json(tests: Sequence[MappedTest]) -> dict[str, object]:
    """Plain values for JSON: {"tests": rows of `row_of`, "through_origin", "with_threshold"}; a line that cannot be
    fitted is None.
    """
    through, threshold = lines_of(tests)
    return {
        "tests": [row_of(test) for test in tests],
        "through_origin": _line_json(through),
        "with_threshold": _line_json(threshold),
    }


def _line_json(line: RegressionLine | None) -> dict[str, object] | None:
    if line is None:
        return None
    known = line.tests > 1
    return {
        "slope_mm3_per_J": line.slope_mm3_per_J,
        "slope_interval95": list(line.slope_interval95) if known else None,
        "threshold_J": line.threshold_J,
        "threshold_interval95": list(line.threshold_interval95),
        "explained": None if line.explained != line.explained else line.explained,
        "tests": line.tests,
    }


def write_maps(tests: Sequence[MappedTest], folder: Path, fatigue_limit_MPa: float | None = None) -> list[Path]:
    """Write maps.html and tests.csv into a folder, which is created if missing, and return their paths.

    fatigue_limit_MPa: tension at which the material cracks, drawn as the only line; None for lines at round values.
    Raises ResultError if there is no test, tests are of both contacts at a point and line contacts, or a file cannot be
    written.
    """
    if not tests:
        raise ResultError("there is no test to draw.")
    if len({test.extent.per for test in tests}) > 1:
        raise ResultError(
            "tests of crossed wires and of line contacts share no map, as loads are in newtons there and in newtons "
            "per millimetre here: draw one of each kind."
        )
    page = maps_page(tests, fatigue_limit_MPa)
    with writing(ResultError, f"cannot write the maps to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        rows = [row_of(test) for test in tests]
        return [write_text(folder / PAGE_NAME, page), write_csv(folder / TABLE_NAME, rows)]


def maps_page(tests: Sequence[MappedTest], fatigue_limit_MPa: float | None = None) -> str:
    """Self-contained HTML page of the maps; fatigue_limit_MPa: as in `write_maps`."""
    through, threshold = lines_of(tests)
    return frame.rendered(
        HERE / "maps_page.html",
        {
            "tests": [row_of(test) for test in tests],
            "columns": columns_of(tests),
            "per": tests[0].extent.per,
            "contacts": any(test.contact is not None for test in tests),
            "sentences": sentences(tests),
            "through": through,
            "threshold": threshold,
            "fatigue_limit": fatigue_limit_MPa,
            "transition": TRANSITION,
            "data": frame.embedded(page_data(tests, fatigue_limit_MPa)),
            "script": frame.script(frame.HERE / "charts.js", REPORT / "slider.js", HERE / "maps_page.js"),
        },
    )


def page_data(tests: Sequence[MappedTest], fatigue_limit_MPa: float | None = None) -> dict[str, object]:
    """The page's data as plain values, for JSON; fatigue_limit_MPa: as in `write_maps`."""
    through, threshold = lines_of(tests)
    contacts = groups(tests)
    reach, loads = _extent(tests, contacts)
    labels = labels_of([(test.displacement_amplitude_um, test.normal_load_N) for test in tests])
    return {
        "per": tests[0].extent.per,
        "tests": [_test(label, test) for label, test in zip(labels, tests, strict=True)],
        "regimes": {regime: {"color": colour, "shape": shape} for regime, (colour, shape) in MARKS.items()},
        "contacts": [_boundaries(contact, reach, loads, fatigue_limit_MPa) for contact in contacts],
        "reach": numbers(np.array(reach)),
        "loads": numbers(np.array(loads)),
        "lines": [
            {"slope": number(1e3 * line.slope_mm3_per_J), "threshold": number(line.threshold_J)}
            for line in (through, threshold)
            if line is not None
        ],
    }


def groups(tests: Iterable[MappedTest]) -> list[FreshContact]:
    """One fresh contact for all tests of the same bodies, with the medians of their friction and rig compliance."""
    found: dict[tuple[Any, ...], list[FreshContact]] = {}
    for contact in (test.contact for test in tests if test.contact is not None):
        found.setdefault((contact.bodies, contact.gap_per_mm), []).append(contact)
    return [
        replace(
            own[0],
            friction=float(np.median([one.friction for one in own])),
            rig_um_per_N=float(np.median([one.rig_um_per_N for one in own])),
        )
        for own in found.values()
    ]


def _extent(
    tests: Sequence[MappedTest], contacts: Sequence[FreshContact]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Lowest and highest displacement in µm, and load in N, of the maps."""
    amplitudes = [test.displacement_amplitude_um for test in tests]
    loads = [test.normal_load_N for test in tests]
    low = min(loads) / BEYOND
    slides = [float(transition(contact, [low]).contact_um[0]) for contact in contacts]
    return (min([*amplitudes, *slides]) / 1.5, max(amplitudes) * BEYOND), (low, max(loads) * BEYOND)


def labels_of(places: Sequence[tuple[float, float]]) -> list[str]:
    """Label of each test, its number from 1; tests at nearly the same place share one such as "1–3, 5" at the first,
    others get "". places: displacement amplitude and load of each test, both positive.
    """
    logs = np.log(np.array(places))
    free, labels = list(range(len(places))), [""] * len(places)
    while free:
        here = [k for k in free if np.abs(logs[k] - logs[free[0]]).max() < NEAR]
        labels[here[0]] = _runs([k + 1 for k in here])
        free = [k for k in free if k not in here]
    return labels


def _runs(numbers: Sequence[int]) -> str:
    """Increasing numbers as text with ranges: "1–3, 5"."""
    runs: list[list[int]] = []
    for one in numbers:
        if runs and one == runs[-1][-1] + 1:
            runs[-1].append(one)
        else:
            runs.append([one])
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def _test(label: str, test: MappedTest) -> dict[str, object]:
    return {
        "label": label,
        "name": test.name,
        "regime": test.regime,
        "cracks": test.cracks,
        "amplitude": number(test.displacement_amplitude_um),
        "load": number(test.normal_load_N),
        "energy": numbers(np.array([one.energy_J for one in test.worn])),
        "volume": numbers(1e3 * np.array([one.volume_mm3 for one in test.worn])),
        "cycles": [max(one.cycle, 1) for one in test.sliding],
        "energy_ratio": numbers(np.array([one.energy_ratio for one in test.sliding])),
        "system_free_ratio": numbers(np.array([one.system_free_ratio for one in test.sliding])),
    }


def _boundaries(
    contact: FreshContact, reach: tuple[float, float], loads: tuple[float, float], limit_MPa: float | None
) -> dict[str, object]:
    slides = transition(contact, np.geomspace(*loads, POINTS))
    tensions = tension_lines(contact, reach[1], loads, () if limit_MPa is None else (limit_MPa,))
    rig = "rigid rig" if contact.rig_um_per_N < 1e-3 else f"rig {frame.figure(1e3 / contact.rig_um_per_N)} N/mm"
    return {
        "label": f"{frame.figure(contact.ball_diameter_mm)} mm, µ {frame.figure(contact.friction, 2)}, {rig}",
        "load": numbers(slides.normal_load_N),
        "contact": numbers(slides.contact_um),
        "test": numbers(slides.test_um),
        "tensions": [
            {"tension": number(one.tension_MPa), "x": numbers(one.displacement_um), "y": numbers(one.normal_load_N)}
            for one in tensions
        ],
    }
