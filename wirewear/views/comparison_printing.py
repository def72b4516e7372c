"""The table of differences as it is printed on a terminal."""

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.quantity import counted
from wirewear.views.comparison import RecordComparison
from wirewear.views.comparison_page import worst_differences
from wirewear.views.differences import REPEATS


def differences_table(comparison: RecordComparison) -> Table:
    """The largest difference of each quantity over its cycles, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Largest differences", title_justify="left")
    table.add_column("from")
    table.add_column("quantity")
    for heading in ("cycle", "difference", "in scatters"):
        table.add_column(heading, justify="right", no_wrap=True)
    worst = worst_differences(comparison.differences)
    for row in worst:
        ratio = "–" if row.in_scatter is None else f"{row.in_scatter:+.2g}"
        difference = f"{row.difference:+.3g} {row.unit}".strip()
        cycle = "" if row.cycle is None else counted(row.cycle)
        table.add_row(row.source, Text(row.quantity), cycle, difference, ratio)
    if any(row.in_scatter is None and row.basis != REPEATS for row in worst):
        table.caption = "– one repeat tells no scatter: differences of quantities with a dash cannot be judged"
    return table
