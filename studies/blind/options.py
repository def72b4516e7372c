"""Options of making blind records, which the command and the script of whole batches share."""

import click

#: Sets of causes of no library, in the order in which they came (`generators.tiers`).
SETS_OF_CAUSES = ("first", "development", "sealed", "unseen", "withheld", "reserved")

outside_option = click.option(
    "--outside",
    type=click.Choice(SETS_OF_CAUSES),
    default=SETS_OF_CAUSES[0],
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
