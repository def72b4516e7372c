"""Options of making blind records, which the command and the script of whole batches share."""

import click

from studies.blind.causes import SETS

outside_option = click.option(
    "--outside",
    type=click.Choice(SETS),
    default=SETS[0],
    show_default=True,
    help="Causes of no library that are drawn.",
)

stated_scatter_option = click.option(
    "--stated-scatter",
    type=click.FloatRange(0.0, 1.0),
    default=0.0,
    show_default=True,
    help="Share of records that state the scatter between tests.",
)
