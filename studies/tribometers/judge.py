"""How much of the applied displacement the contact and the rig take, and what remains to be explained.

    python -m studies.tribometers.judge TABLE.csv [--json]

`--help` names the columns of the table; README.md explains the method.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
from rich import box
from rich.table import Table
from rich.text import Text

from studies.study_script import StudyScript
from wirewear.app.cli.consoles import progress_bar, wide_console
from wirewear.base.writing import json_text
from wirewear.reference import contact_modulus, mindlin_stiffness, tangential_contact_modulus

from .contact_stiffness import line_contact_stiffness
from .rows import CONSTANTS, CONTACTS, OPTIONAL, REQUIRED, SPECIMEN_CONSTANTS, TribometerRow, read_rows, row_of

#: The loss counts as explained within this share of itself: what reading loops off published figures allows.
TOLERANCE = 0.10

_COLUMNS = (
    ("P [N]", "normal_load_N", "g"),
    ("µ_max", "friction_max", "g"),
    ("K_t,c [N/µm]", "contact_stiffness_N_per_um", ".4g"),
    ("stated", "stated_contact_stiffness_N_per_um", ".4g"),
    ("K_t,m", "measured_stiffness_N_per_um", ".4g"),
    ("rig", "rig_stiffness_N_per_um", ".4g"),
    ("δ0 [µm]", "slip_amplitude_um", ".4g"),
    ("predicted", "predicted_slip_amplitude_um", ".4g"),
    ("lost", "lost_um", ".3g"),
    ("in contact", "lost_in_contact_um", ".3g"),
    ("in rig", "lost_in_rig_um", ".3g"),
    ("unexplained", "unexplained_um", ".2g"),
)

Progress = Callable[[int, int], None]  #: Called with how many rows are done and how many there are.


@dataclass(frozen=True)
class Tribometer:
    """One row judged: where the lost displacement δa − δ0 goes, in µm, while the force falls from its peak µP to zero.

    K_t,m is the slope of a line over half of the micro-slip region, thus down to about zero force: µP/K_t,m is what
    contact and rig take together, the contact's creep included.

    contact_length_mm: of the line contact, None for crossed cylinders.  rig_stiffness_N_per_um: of the spring in
    series with K_t,c that explains K_t,m, that is bodies and fixtures beyond the contact's points of reference;
    lost_in_rig_um is its share. Both are None if the loop is stiffer than its contact.
    The loss is the sum of lost_in_contact_um, lost_in_rig_um and unexplained_um.
    """

    source: str
    contact: str
    normal_load_N: float
    friction_max: float
    cycles: float | None
    contact_length_mm: float | None
    contact_stiffness_N_per_um: float
    stated_contact_stiffness_N_per_um: float | None
    measured_stiffness_N_per_um: float
    rig_stiffness_N_per_um: float | None
    displacement_amplitude_um: float
    slip_amplitude_um: float
    predicted_slip_amplitude_um: float
    lost_um: float
    lost_in_contact_um: float
    lost_in_rig_um: float | None
    unexplained_um: float
    verdict: str


def read_tribometers(path: Path, progress: Progress | None = None) -> tuple[Tribometer, ...]:
    """Read and judge the rows of a CSV file.
    Raises RecordError, in one sentence with line and column, if the file cannot be read, or a value is missing or
    wrong.
    """
    return judged(read_rows(path), progress)


def figures(row: Mapping[str, Any]) -> dict[str, float]:
    """What the atlas compares of a row of its table (studies/atlas/infante2020_tribometers)."""
    texts = {name: "" if value is None else str(value) for name, value in row.items()}
    found = judge(row_of(texts, f"test {row['test']}"))
    return {
        "contact_stiffness_N_per_um": found.contact_stiffness_N_per_um,
        "predicted_slip_amplitude_um": found.predicted_slip_amplitude_um,
    }


def judged(rows: Sequence[TribometerRow], progress: Progress | None = None) -> tuple[Tribometer, ...]:
    """Judge rows one by one."""
    result = []
    for done, row in enumerate(rows):
        if progress is not None:
            progress(done, len(rows))
        result.append(judge(row))
    return tuple(result)


def judge(row: TribometerRow) -> Tribometer:
    """Split a row's loss into what contact and rig take and what is unexplained."""
    length = None if row.crossed else row.contact_length_mm or hertz_length(row)
    own = _contact_stiffness(row, length)
    measured, force = row.measured_stiffness_N_per_um, row.friction_max * row.normal_load_N
    stroke = row.displacement_amplitude_um
    lost, taken = stroke - row.slip_amplitude_um, force / measured
    softness = 1.0 / measured - 1.0 / own
    rig = 1.0 / softness if softness > 0.0 else None
    return Tribometer(
        source=row.source,
        contact=row.contact,
        normal_load_N=row.normal_load_N,
        friction_max=row.friction_max,
        cycles=row.cycles,
        contact_length_mm=length,
        contact_stiffness_N_per_um=own,
        stated_contact_stiffness_N_per_um=row.theoretical_stiffness_N_per_um,
        measured_stiffness_N_per_um=measured,
        rig_stiffness_N_per_um=rig,
        displacement_amplitude_um=stroke,
        slip_amplitude_um=row.slip_amplitude_um,
        predicted_slip_amplitude_um=stroke - taken,
        lost_um=lost,
        lost_in_contact_um=taken if rig is None else force / own,
        lost_in_rig_um=None if rig is None else force / rig,
        unexplained_um=lost - taken,
        verdict=_verdict(lost, taken, stroke, None if rig is None else measured / rig),
    )


def hertz_length(row: TribometerRow) -> float:
    """Length in mm of a line contact of this half-width, from a² = 4(P/L)R/(πE*) (Johnson 1985, section 4.2)."""
    modulus = contact_modulus(row.pad, row.specimen)
    return 4.0 * row.normal_load_N * row.radius_mm / (math.pi * modulus * row.contact_half_width_mm**2)


def _contact_stiffness(row: TribometerRow, length_mm: float | None) -> float:
    """K_t,c in N/µm: finite elements for a line contact, Mindlin's 2G*a for crossed cylinders."""
    if length_mm is None:
        modulus = tangential_contact_modulus(row.pad, row.specimen)
        return 1e-3 * mindlin_stiffness(modulus, row.contact_half_width_mm)
    return 1e-3 * length_mm * line_contact_stiffness(row.radius_mm, row.contact_half_width_mm, row.pad, row.specimen)


def _verdict(lost: float, taken: float, stroke: float, rig_share: float | None) -> str:
    if rig_share is None:
        return "check the reading of displacement: the loop is stiffer than its contact"
    if abs(lost - taken) <= TOLERANCE * lost:
        return f"compliance explains it, {rig_share:.0%} of it outside the contact"
    if lost > taken:
        return f"free play or a lagging sensor: {lost - taken:.3g} µm more are lost than compliance takes"
    if taken >= stroke:
        return "not one loop in gross slip: at this stiffness the peak force would take the whole stroke"
    return f"peak friction above the plateau: the loss takes a force of {lost / taken:.0%} of the peak"


def tribometers_table(rows: Sequence[Tribometer]) -> Table:
    """The figures of each row, to be printed with rich; `verdicts_table` says what they mean."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("source")
    for heading, _, _ in _COLUMNS:
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        values = ((getattr(row, name), digits) for _, name, digits in _COLUMNS)
        numbers = ("–" if value is None else f"{value:{digits}}" for value, digits in values)
        table.add_row(Text(row.source), *numbers)
    return table


def verdicts_table(rows: Sequence[Tribometer]) -> Table:
    """The verdict on each row, to be printed with rich."""
    table = Table("source", "P [N]", "µ_max", "verdict", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for row in rows:
        table.add_row(Text(row.source), f"{row.normal_load_N:g}", f"{row.friction_max:g}", row.verdict)
    return table


COLUMNS = (
    f"Columns: {', '.join(('source', *REQUIRED))}; optional are {', '.join(OPTIONAL)}. A contact is one of "
    f"{', '.join(CONTACTS)}. Materials are a name of `wirewear materials` or two, as in En31/En24; others have "
    f"{', '.join(CONSTANTS)}, and where the flat differs {', '.join(SPECIMEN_CONSTANTS)}."
)


@click.command(cls=StudyScript, epilog=COLUMNS)
@click.argument("path", metavar="TABLE.csv", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the rows as JSON.")
def main(path: Path, as_json: bool) -> None:
    """Say for each tribometer whether compliance explains the displacement that it loses."""
    with progress_bar() as bar:
        task = bar.add_task("contact stiffness")
        rows = read_tribometers(path, lambda done, of: bar.update(task, completed=done, total=of))
    if as_json:
        click.echo(json_text([asdict(row) for row in rows]))
        return
    wide_console(132).print(tribometers_table(rows), verdicts_table(rows))


if __name__ == "__main__":
    main()
