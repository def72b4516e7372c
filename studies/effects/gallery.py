"""A picture of every effect from real runs of the steel-wire test, 100 000 cycles at quick fidelity.

    python -m studies.effects.gallery [--output DIR] [--only NAME]... [--fidelity LEVEL]

Each effect is run at the size that its library entry calls easy to see, beside one nominal run. Finished runs are
kept, interrupted ones continued, so the script may be stopped and started again at any time. It leaves in DIR
<effect>.png, effects.png with a loop of each, and changes.csv: by how much the figures of each cycle's loop change.
"""

from functools import partial
from pathlib import Path

import click
import numpy as np
import polars as pl
from matplotlib.figure import Figure

from studies.study_script import StudyScript
from wirewear.base.writing import prepared_folder, write_csv
from wirewear.diagnosis.wording import plain
from wirewear.effects import all_effects
from wirewear.pictures.panels import draw_loop
from wirewear.pictures.smooth import smooth_loop
from wirewear.pictures.style import cycle_name, new_figure, save
from wirewear.simulation import ProgressBar
from wirewear.sweeps.signature import Signature, signature_of, signature_study
from wirewear.test import FIDELITIES
from wirewear.views.signature_picture import CHANGED, NOMINAL, draw_signature

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


def sheet(signatures: list[Signature]) -> Figure:
    """One small panel for each effect: the loop of the cycle at which it differs most, on the nominal one."""
    columns = 4
    lines = -(-len(signatures) // columns)
    figure = new_figure(1.85 * lines + 0.5)
    panels = list(figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False).flat)
    for axes, signature in zip(panels, signatures, strict=False):
        place = max(range(len(signature.cycles)), key=partial(_difference, signature))
        nominal, changed = signature.loops[place]
        for loop, style in ((nominal, NOMINAL), (changed, CHANGED)):
            draw_loop(axes, *smooth_loop(loop), **style)
        axes.set_title(plain(signature.effect.name), fontsize=7.5, pad=20)
        energy, friction = (
            100.0 * signature.changes()[name][place] for name in ("dissipated_energy_mJ", "friction_max")
        )
        words = f"cycle {cycle_name(nominal.cycle)}\nenergy {_percent(energy)}, max Q/P {_percent(friction)}"
        axes.text(0.0, 1.03, words, fontsize=6.5, ha="left", va="bottom", transform=axes.transAxes)
        axes.tick_params(labelsize=7)
    for place, axes in enumerate(panels[len(signatures) :], len(signatures)):
        axes.set_visible(False)
        panels[place - columns].tick_params(labelbottom=True)
    figure.suptitle("dashed: test run without the effect; orange: with it", fontsize=8)
    figure.supxlabel("displacement δ [µm]", fontsize=8)
    figure.supylabel("tangential force Q [N]", fontsize=8)
    return figure


def _percent(change: float) -> str:
    shown = f"{change:+.1f}"
    return f"{'0.0' if float(shown) == 0.0 else shown} %".replace("-", "\u2212")


def _difference(signature: Signature, place: int) -> float:
    """What the eye sees of a pair: mean distance from one loop to the other, coordinates relative to the nominal's."""
    nominal, changed = (np.array(smooth_loop(loop)) for loop in signature.loops[place])
    scale = np.ptp(nominal, axis=1)[:, None]
    apart = np.linalg.norm((changed / scale)[:, :, None] - (nominal / scale)[:, None, :], axis=0)
    return float(apart.min(axis=1).mean())


@click.command(cls=StudyScript)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/effects"), show_default=True)
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(tuple(all_effects())),
    help="This effect only; may be repeated.  [default: all]",
)
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True)
def main(output: Path, only: tuple[str, ...], fidelity: str) -> None:
    """Run and draw the effects."""
    prepared_folder(output)
    study = signature_study()
    signatures = []
    for name, kind in all_effects().items():
        if only and name not in only:
            continue
        signature = signature_of(
            kind.sized("easy", study.stated), output, study=study, fidelity=fidelity, observer_of=ProgressBar
        )
        signatures.append(signature)
        print(draw_signature(signature, output / f"{name}.png"))
    print(save(lambda: sheet(signatures), output / "effects.png"))
    changes = pl.concat([rows(signature) for signature in signatures]).with_columns(pl.col(pl.Float64).round(6))
    print(write_csv(output / "changes.csv", changes))


if __name__ == "__main__":
    main()
