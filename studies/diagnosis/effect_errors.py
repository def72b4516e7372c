"""How far the fast model is off other solvers with an effect in it, learned from pairs of runs that hold one.

    python -m studies.diagnosis.gap_free PAIRS --tests 10 --effects [--reference T1]
    python -m studies.diagnosis.effect_errors PAIRS

Every record of PAIRS holds an effect whose size stands beside it. The fast model is given that size; what it leaves
over is a normal deviate whose covariance is that of solvers without a gap, of the freedom of form that the effect has,
of its parameters, which a diagnosis fits, and of a smooth error that is a share of what the effect changes. The share
that makes the pairs of an effect likeliest is printed beside the one in use (`model_error` of wirewear/effects).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy.linalg import cho_factor, cho_solve

from studies.json_files import read_json
from studies.study_script import StudyScript, understanding
from wirewear import RecordError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis.infer.covariance import smooth_covariance, solver_covariance
from wirewear.diagnosis.observe.observable import Scale
from wirewear.diagnosis.observe.observed_record import read_at_corners
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.nominal import nominal_run, nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import all_effects

from .gap_free import TRUTH

Array = NDArray[np.float64]

FREE = 0.1  #: Relative deviation of each parameter: a diagnosis finds it.
SHARES = (0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.13, 0.16, 0.2, 0.25, 0.3, 0.4, 0.5)  #: Shares that are tried.


@dataclass(frozen=True, eq=False)
class EffectPair:
    """One record with a known effect against the fast model that is given it.

    Attributes:
        name, effect: of both.
        residual: (n,) measured less computed.
        fixed: (n, n) covariance without an error of the fast model with the effect.
        error: (n, n) covariance of an error as large as the change itself.
        worst: the observable of the largest χ² per number, and that.
    """

    name: str
    effect: str
    residual: Array
    fixed: Array
    error: Array
    worst: tuple[str, float]

    def misfit(self, share: float) -> float:
        """Chi square per number."""
        factor = cho_factor(self.fixed + share**2 * self.error, lower=True)
        return float(self.residual @ cho_solve(factor, self.residual)) / self.residual.size

    def log_likelihood(self, share: float) -> float:
        """Of the residual, but for a constant."""
        factor = cho_factor(self.fixed + share**2 * self.error, lower=True)
        squares = float(self.residual @ cho_solve(factor, self.residual))
        return -0.5 * squares - float(np.log(np.diag(factor[0])).sum())


def pairs_of(folder: Path) -> Iterator[EffectPair]:
    """All pairs of a folder that hold one effect."""
    for path in sorted(path.parent for path in folder.glob(f"*/{TRUTH}")):
        try:
            truths = _true_effects(path / TRUTH)
            if len(truths) == 1:
                yield _pair_of(path, *truths[0])
        except WirewearError as problem:
            click.echo(f"{path.name}: {problem}")


def _true_effects(truth: Path) -> list[tuple[str, dict[str, float]]]:
    """The effects in a record, each with its parameters."""
    listed = read_json(truth, RecordError, "list of true effects")
    with understanding(truth, "list of true effects"):
        for one in listed:
            all_effects()[one["effect"]](**one["parameters"])
        return [(one["effect"], one["parameters"]) for one in listed]


def _pair_of(path: Path, effect: str, parameters: dict[str, float]) -> EffectPair:
    record, _ = read_at_corners(read_record(path))
    study = nominal_study(record)
    states = WearStates.of_run(nominal_run(study))
    nominal = nominal_inputs(study, record.tables.conditions.drive)
    kind = all_effects()[effect]
    changed = nominal.with_effect(kind(**parameters))
    observed = reduce(record)
    keep = np.isfinite(observed.values[0])
    layout = observed.layout.taken(keep)
    before, after = (layout.observed(simulate(states, setup, layout.cycles)) for setup in (nominal, changed))
    fixed = solver_covariance(states, changed, layout) + np.diag(observed.noise[0, keep] ** 2)
    for name, value in parameters.items():
        up, down = (
            layout.observed(
                simulate(states, nominal.with_effect(kind(**{**parameters, name: value * side})), layout.cycles)
            )
            for side in (1.0 + 0.5 * FREE, 1.0 - 0.5 * FREE)
        )
        fixed = fixed + np.outer(up - down, up - down)
    residual = observed.values[0, keep] - after
    scale = Scale(nominal.amplitude_um, nominal.plateau_force_N)
    worst = ("", 0.0)
    for part in layout:
        rest, block = residual[part.rows], fixed[part.rows, part.rows]
        squares = float(rest @ np.linalg.solve(block, rest)) / rest.size
        worst = max(worst, (part.observable.name, squares), key=lambda one: one[1])
    return EffectPair(
        path.name,
        effect,
        residual,
        np.asarray(fixed + 1e-9 * np.diag(np.diag(fixed))),
        smooth_covariance(layout, np.abs(np.nan_to_num(after - before)), scale),
        worst,
    )


def likeliest(pairs: Sequence[EffectPair]) -> float:
    """The share that makes pairs likeliest."""
    return max(SHARES, key=lambda share: sum(pair.log_likelihood(share) for pair in pairs))


@click.command(cls=StudyScript)
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
def main(folder: Path) -> None:
    """Learn the fast model's errors from the pairs with effects in FOLDER."""
    pairs, console = list(pairs_of(folder)), wide_console(130)
    if not pairs:
        raise RecordError(f"{folder} holds no record with one effect: python -m studies.diagnosis.gap_free makes them.")
    table = Table("effect", "pairs", "used", "likeliest", "χ²/n without", "with it", "worst", box=box.SIMPLE_HEAD)
    for effect in dict.fromkeys(pair.effect for pair in pairs):
        own = [pair for pair in pairs if pair.effect == effect]
        share = likeliest(own)
        figures = [" ".join(f"{pair.misfit(s):.2f}" for pair in own) for s in (0.0, share)]
        worst = " ".join(f"{pair.worst[0]} {pair.worst[1]:.1f}" for pair in own)
        used = all_effects()[effect].model_error
        table.add_row(effect, str(len(own)), f"{used:g}", f"{share:g}", *figures, worst)
    console.print(table)


if __name__ == "__main__":
    main()
