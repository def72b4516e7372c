"""The table of differences as it is printed on a terminal."""

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.comparison.comparison import Comparison
from wirewear.comparison.differences import Difference


def differences_table(comparison: Comparison) -> Table:
    """The largest difference of each quantity over its cycles, to be printed with rich."""
    worst: dict[tuple[str, str], Difference] = {}
    for row in comparison.differences:
        key = row.source, row.quantity
        if key not in worst or abs(row.difference) > abs(worst[key].difference):
            worst[key] = row
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Largest differences", title_justify="left")
    table.add_column("from")
    table.add_column("quantity")
    for heading in ("cycle", "difference", "in scatters"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in worst.values():
        ratio = "–" if row.in_scatter is None else f"{row.in_scatter:+.2g}"
        difference = f"{row.difference:+.3g} {row.unit}".strip()
        cycle = "" if row.cycle is None else str(row.cycle)
        table.add_row(row.source, Text(row.quantity), cycle, difference, ratio)
    return table
