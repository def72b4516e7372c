"""A line contact's comparison as a table for a terminal."""

from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.base.quantity import counted
from wirewear.records.line_comparing import LineComparison


def line_differences_table(comparison: LineComparison) -> Table:
    """Measured and simulated figures, to be printed with rich."""
    title = f"{comparison.record.name} against {comparison.result.label}"
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=escape(title), title_justify="left")
    table.add_column("figure", no_wrap=True)
    for heading in ("cycle", "measured", "scatter", "simulated", "measured over simulated"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in comparison.differences:
        scatter = "–" if row.scatter is None else f"{row.scatter:.3g}"
        figures = counted(row.cycle), f"{row.measured:.4g}", scatter, f"{row.simulated:.4g}", f"{row.relative:+.1%}"
        table.add_row(escape(row.quantity), *figures)
    return table
