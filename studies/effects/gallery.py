"""A picture of every effect from real runs of the steel-wire test, 100 000 cycles at quick fidelity.

    python studies/effects/gallery.py [--output DIR] [--only NAME]... [--fidelity LEVEL]

Each effect is run at the size that its library entry calls easy to see, beside one nominal run. Finished runs are
kept, interrupted ones continued, so the script may be stopped and started again at any time. It leaves DIR/<effect>.png
and DIR/changes.csv: by how much the figures of each cycle's loop change.
"""

from pathlib import Path

import click
import polars as pl

from wirewear.effects import all_effects
from wirewear.effects.signature import Signature, signature_of, signature_study
from wirewear.effects.signature_picture import draw_signature
from wirewear.observers import ProgressBar

HEADINGS = {
    "slip_amplitude_um": "slip_amplitude_change",
    "dissipated_energy_mJ": "dissipated_energy_change",
    "friction_max": "largest_friction_change",
}


def rows(signature: Signature) -> pl.DataFrame:
    """Changes of one effect, a row for each cycle; shares of the nominal figures."""
    changes = {HEADINGS[name]: change for name, change in signature.changes().items()}
    return pl.DataFrame(
        {"effect": [signature.effect.name] * len(signature.cycles), "cycle": signature.cycles, **changes}
    )


@click.command()
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/effects"), show_default=True)
@click.option("--only", multiple=True, help="This effect only; may be repeated.  [default: all]")
@click.option("--fidelity", default="quick", show_default=True)
def main(output: Path, only: tuple[str, ...], fidelity: str) -> None:
    """Run and draw the effects."""
    study = signature_study()
    tables = []
    for name, kind in all_effects().items():
        if only and name not in only:
            continue
        signature = signature_of(
            kind.sized("easy", study), output, study=study, fidelity=fidelity, observer_of=ProgressBar
        )
        tables.append(rows(signature))
        print(draw_signature(signature, output / f"{name}.png"))
    pl.concat(tables).write_csv(output / "changes.csv", float_precision=6)
    print(output / "changes.csv")


if __name__ == "__main__":
    main()
