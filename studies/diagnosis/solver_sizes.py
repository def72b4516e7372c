"""How far solvers differ without a gap, learned from pairs of runs: sizes and means of greatest likelihood.

    python -m studies.diagnosis.gap_free PAIRS --tests 24
    python -m studies.diagnosis.gap_free RIGS --tests 24 --rigs 3
    python -m studies.diagnosis.solver_sizes PAIRS... [--scattered RIGS]... [--write COMMIT]

Every record of PAIRS is one solver's view of a test without a gap; the other is the diagnosis' own nominal run. RIGS
are gap-free ones with scatter between specimens, or those of spent blind batches. Their
difference is a normal deviate whose covariance has a size for each numerical freedom of the fast model and for each
kind of observable (wirewear/diagnosis/infer/covariance.py). The sizes that make all pairs likeliest, with a
weak expectation that they are what calibration.toml says now, are printed beside those, and what tests left out of the
fit say of them. `--write` puts them into calibration.toml.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from studies.study_script import StudyScript
from wirewear import RecordError
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis.calibration import FILE
from wirewear.diagnosis.surrogate.candidates import EXPECTED
from wirewear.diagnosis.surrogate.wear_states import NUMERICAL

from .gap_free_pairs import Pair, pairs_of

Array = NDArray[np.float64]


WITHIN = 1.2  #: Deviation of the logarithm of a factor on a present size before looking: a tenth to ten times.

#: Sizes are not lowered below this share of what they are: solvers may agree better with each other than with rigs, and
#: sizes lowered by 0.6 raised false alarms under a friction law that no pair held.
LEAST = 1.0

#: Sizes in calibration.toml of what a factor of each component multiplies.
ENTRIES: Mapping[str, tuple[str, ...]] = {
    "stick": ("observe.along_branches.stick.tip_share",),
    "knee": ("observe.along_branches.knee_peak.peak_share", "observe.along_branches.knee_peak.wall_share"),
    "plateau": ("observe.along_branches.plateau.slope_share",),
    "energy": ("observe.channels.evolution.slope_share",),
    "hooks": ("infer.covariance.hooks.whole",),
}

KEPT = ("compliance",)  #: Freedoms that keep their sizes: of how wires are held, which is alike in all pairs.


@dataclass(frozen=True, eq=False)
class Sizes:
    """Logarithms of factors on present deviations, by name, and shifts of the means in present deviations."""

    freedoms: tuple[str, ...]
    parts: tuple[str, ...]
    log_factors: Array
    shifts: Array

    @classmethod
    def present(cls, pairs: Sequence[Pair]) -> "Sizes":
        """Sizes that leave all as it is."""
        parts = tuple(sorted({name for pair in pairs for name in pair.parts}))
        count = len(NUMERICAL) + len(parts)
        return cls(tuple(NUMERICAL), parts, np.zeros(count), np.zeros(len(EXPECTED)))

    def of(self, values: Array) -> "Sizes":
        """Others, from one row of numbers."""
        count = self.log_factors.size
        return replace(self, log_factors=values[:count], shifts=values[count:])

    def covariance(self, pair: Pair) -> Array:
        """Covariance (n, n) of the difference of a pair's n numbers under these sizes, in their own units."""
        factors = np.exp(self.log_factors)
        columns = pair.freedoms * factors[: len(self.freedoms)]
        total = pair.fixed + columns @ columns.T
        for name, factor in zip(self.parts, factors[len(self.freedoms) :], strict=True):
            if name in pair.parts:
                total = total + factor**2 * pair.parts[name]
        return np.asarray(total + 1e-9 * np.diag(np.diag(total)))

    def mean(self, pair: Pair) -> Array:
        """Mean (n,) of a pair's difference."""
        places = [self.freedoms.index(name) for name in EXPECTED]
        return np.asarray(pair.freedoms[:, places] @ self.shifts)


def likelihood(sizes: Sizes, pairs: Sequence[Pair]) -> tuple[float, Array]:
    """Log-likelihood of pairs with the expectation of the sizes, and its gradient.

    Pairs of one solver on one test count as one: more of them show no more of how solvers differ.
    """
    values = np.concatenate([sizes.log_factors, sizes.shifts])
    log_factors = sizes.log_factors
    total = -0.5 * float(((log_factors / WITHIN) ** 2).sum())
    gradient = np.concatenate([-log_factors / WITHIN**2, np.zeros(sizes.shifts.size)])
    kept = [sizes.freedoms.index(name) for name in KEPT]
    alike = Counter((pair.test, pair.solver) for pair in pairs)
    factors = np.exp(log_factors)
    places = [sizes.freedoms.index(name) for name in EXPECTED]
    for pair in pairs:
        weight = 1.0 / alike[pair.test, pair.solver]
        covariance = sizes.covariance(pair)
        factor = cho_factor(covariance, lower=True)
        rest = pair.residual - sizes.mean(pair)
        along = cho_solve(factor, rest)
        inverse = cho_solve(factor, np.eye(rest.size))
        total += weight * (-0.5 * float(rest @ along) - float(np.log(np.diag(factor[0])).sum()))
        columns = pair.freedoms * factors[: len(sizes.freedoms)]
        whitened = inverse @ columns
        moved = [float((columns[:, i] @ along) ** 2 - columns[:, i] @ whitened[:, i]) for i in range(columns.shape[1])]
        for name, size in zip(sizes.parts, factors[len(sizes.freedoms) :], strict=True):
            block = pair.parts.get(name)
            if block is None:
                moved.append(0.0)
            else:
                moved.append(size**2 * (float(along @ block @ along) - float(np.sum(inverse * block))))
        gradient[: len(moved)] += weight * np.array(moved)
        gradient[len(moved) :] += weight * (pair.freedoms[:, places].T @ along)
    gradient[kept] = 0.0
    return total, np.asarray(gradient[: values.size])


def learned(pairs: Sequence[Pair], start: Sizes, iterations: int = 60) -> Sizes:
    """The likeliest sizes."""

    def cost(values: Array) -> tuple[float, Array]:
        total, gradient = likelihood(start.of(values), pairs)
        return -total, -gradient

    begin = np.concatenate([start.log_factors, start.shifts])
    count = start.log_factors.size
    bounds = [(float(np.log(LEAST)), None)] * count + [(None, None)] * (begin.size - count)
    found = minimize(cost, begin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": iterations})
    return start.of(np.asarray(found.x))


def misfits(sizes: Sizes, pairs: Sequence[Pair]) -> dict[str, float]:
    """Chi square per number of each pair."""
    found = {}
    for pair in pairs:
        rest = pair.residual - sizes.mean(pair)
        found[pair.name] = float(rest @ cho_solve(cho_factor(sizes.covariance(pair), lower=True), rest)) / rest.size
    return found


def left_out(pairs: Sequence[Pair], sizes: Sizes, iterations: int = 15) -> dict[str, float]:
    """Chi square per number of each pair by sizes that were learned on the other tests."""
    found: dict[str, float] = {}
    for test in dict.fromkeys(pair.test for pair in pairs):
        others = learned([pair for pair in pairs if pair.test != test], sizes, iterations)
        found |= misfits(others, [pair for pair in pairs if pair.test == test])
    return found


def entries(sizes: Sizes) -> dict[str, float]:
    """Factors (of sizes) by their names in calibration.toml; the means of the freedoms as they are to be."""
    factors = dict(zip((*sizes.freedoms, *sizes.parts), np.exp(sizes.log_factors).tolist(), strict=True))
    found = {f"surrogate.wear_states.freedoms.{name}": factors[name] for name in sizes.freedoms if name not in KEPT}
    for name in sizes.parts:
        found |= dict.fromkeys(ENTRIES[name], factors[name])
    return found


def written(text: str, sizes: Sizes, commit: str) -> str:
    """calibration.toml with these sizes and means; what stays as it was keeps the commit in which it first stood."""
    means = {
        f"surrogate.candidates.{name}": EXPECTED[name] + shift * NUMERICAL[name]
        for name, shift in zip(EXPECTED, sizes.shifts.tolist(), strict=True)
    }
    table, lines, changed = "", [], entries(sizes)
    for line in text.splitlines():
        lines.append(line)
        if header := re.match(r"\[([\w.]+)\]", line):
            table = header[1]
        entry = re.match(r'(\w+) = \{ value = ([-\d.e]+), unit = "([^"]+)"', line)
        name = f"{table}.{entry[1]}" if entry else ""
        if entry and (name in changed or name in means):
            value = float(f"{means[name] if name in means else float(entry[2]) * changed[name]:.3g}")
            if value != float(entry[2]):
                stated = f'value = {value!r}, unit = "{entry[3]}", source = "pairs", commit = "{commit}"'
                lines[-1] = f"{entry[1]} = {{ {stated} }}"
    return "\n".join(lines) + "\n"


@click.command(cls=StudyScript)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option(
    "--scattered", multiple=True, type=click.Path(exists=True, path_type=Path), help="Gap-free rigs' records."
)
@click.option("--write", metavar="COMMIT", help="Put the sizes into calibration.toml, first in this commit.")
def main(folders: tuple[Path, ...], scattered: tuple[Path, ...], write: str | None) -> None:
    """Learn the sizes of solvers' differences from the pairs in FOLDERS."""
    pairs = [pair for folder in folders for pair in pairs_of(folder)]
    pairs += [pair for folder in scattered for pair in pairs_of(folder, scattered=True)]
    if not pairs:
        raise RecordError("these folders hold no folder with a record that can be read.")
    report(pairs, write)


def report(pairs: Sequence[Pair], write: str | None) -> None:
    """Learn, print, and write if asked to."""
    console = wide_console(130)
    present = Sizes.present(pairs)
    sizes = learned(pairs, present)
    before, after, apart = misfits(present, pairs), misfits(sizes, pairs), left_out(pairs, sizes)
    table = Table("pair", "numbers", "present", "learned", "learned without this test", box=box.SIMPLE_HEAD)
    for pair in pairs:
        figures = (f"{found[pair.name]:.2f}" for found in (before, after, apart))
        table.add_row(pair.name, str(pair.residual.size), *figures)
    table.add_row("mean", "", *(f"{np.mean(list(found.values())):.2f}" for found in (before, after, apart)))
    table.add_row("median", "", *(f"{np.median(list(found.values())):.2f}" for found in (before, after, apart)))
    console.print(table)
    for name, factor in entries(sizes).items():
        console.print(f"{name}: × {factor:.2f}", highlight=False)
    for name, shift in zip(EXPECTED, sizes.shifts.tolist(), strict=True):
        console.print(f"mean of {name}: {EXPECTED[name] + shift * NUMERICAL[name]:.3f}", highlight=False)
    if write:
        FILE.write_text(written(FILE.read_text(encoding="utf-8"), sizes, write), encoding="utf-8")


if __name__ == "__main__":
    main()
