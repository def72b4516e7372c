"""The command that lists the materials known by name."""

from wirewear.faces.group import cli


@cli.command(name="materials")
def materials_command() -> None:
    """List the materials that a study may name, with their elastic constants' sources."""
    from rich import box
    from rich.table import Table

    from wirewear.faces.study_script import wide_console
    from wirewear.study.materials import materials

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("material", no_wrap=True)
    table.add_column("also", no_wrap=True)
    for heading in ("E [GPa]", "ν"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("source", overflow="fold")
    for item in materials():
        modulus, ratio = item.elastic.youngs_modulus_MPa, item.elastic.poissons_ratio
        table.add_row(item.name, ", ".join(item.also), f"{1e-3 * modulus:.4g}", f"{ratio:g}", item.source)
    wide_console(130).print(table)
