"""A second opinion on records, to audit the diagnosis: sampled evidence, and a classifier taught by simulations.

    python -m studies.diagnosis.second_opinion RECORD... [--live 60] [--simulated 150] [--seed 1]

Both look at the same observables under the same covariance as the diagnosis. Nested sampling (dynesty) computes the
evidence of none and of the likeliest effects, where the diagnosis takes Laplace's approximation about the best fit. The
classifier (linear discriminants of whitened observables, scikit-learn) has never seen an evidence: it learned from so
many records of every effect that the fast model made, with noise and solver differences drawn from the covariance.
Neither knows of causes outside the library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy.special import ndtri

from wirewear import RecordError, WirewearError, read_record
from wirewear.diagnosis import Diagnosed, diagnose
from wirewear.diagnosis.infer.inference import Fit, Problem, applied
from wirewear.diagnosis.infer.weighing import relevant
from wirewear.diagnosis.model.candidates import Candidate
from wirewear.study_script import StudyScript, wide_console

Array = NDArray[np.float64]

#: Effects whose evidence is sampled, the likeliest ones.
SAMPLED = 3


@dataclass(frozen=True)
class Opinion:
    """Of one record: what the diagnosis says and both others do.

    Attributes:
        laplace, sampled: log evidences above that of none, by effect.
        learned: the classifier's probabilities by effect, none among them.
    """

    name: str
    verdict: str
    leading: str
    laplace: dict[str, float]
    sampled: dict[str, float]
    learned: dict[str, float]

    @property
    def likeliest(self) -> str:
        """The classifier's choice."""
        return max(self.learned, key=lambda name: self.learned[name])


def sampled_log_evidence(problem: Problem, candidates: Sequence[Candidate], live: int, seed: int) -> float:
    """Log evidence of effects by nested sampling, on the scale of the fits'."""
    import dynesty

    size = sum(len(candidate.unknowns) for candidate in candidates)

    def log_likelihood(z: Array) -> float:
        rest = problem.whitened(applied(candidates, problem.setup, np.clip(z, -4.0, 4.0)))
        return -0.5 * float(rest @ rest)

    sampler = dynesty.NestedSampler(
        log_likelihood, ndtri, size, nlive=live, rstate=np.random.default_rng(seed), bound="single"
    )
    sampler.run_nested(dlogz=0.5, print_progress=False)
    return float(sampler.results.logz[-1])


def learned_probabilities(problem: Problem, fits: Sequence[Fit], number: int, seed: int) -> dict[str, float]:
    """What linear discriminants say, learned from so many simulated records of each effect and of none."""
    from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

    random = np.random.default_rng(seed)
    rows, labels = [], []
    base = problem.whitening @ problem.predicted(problem.setup)
    for one in fits:
        for _ in range(number):
            z = random.standard_normal(sum(len(candidate.unknowns) for candidate in one.candidates))
            setup = applied(one.candidates, problem.setup, z) if one.candidates else problem.setup
            seen = problem.whitening @ problem.predicted(setup) - base + random.standard_normal(base.size)
            rows.append(_squashed(seen))
            labels.append(one.names[0] if one.names else "none")
    learner = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto").fit(np.stack(rows), labels)
    seen = problem.whitening @ problem.mean - base
    probabilities = learner.predict_proba(_squashed(seen)[None])[0]
    return dict(zip(map(str, learner.classes_), probabilities.tolist(), strict=True))


def _squashed(whitened: Array) -> Array:
    """Deviates whose size counts by its logarithm once it is large: effects come in all sizes."""
    return np.asarray(np.sign(whitened) * np.log1p(np.abs(whitened)))


def opinion_on(name: str, diagnosed: Diagnosed, live: int, simulated: int, seed: int) -> Opinion:
    """All three opinions on a diagnosed record."""
    found = diagnosed.search
    near = relevant(found.singles)[:SAMPLED]
    none = found.none.log_evidence
    sampled = {one.names[0]: sampled_log_evidence(found.problem, one.candidates, live, seed) - none for one in near}
    return Opinion(
        name,
        diagnosed.diagnosis.verdict,
        " + ".join(found.best.names) or "none",
        {one.names[0]: one.log_evidence - none for one in near},
        sampled,
        learned_probabilities(found.problem, (found.none, *found.singles), simulated, seed),
    )


@click.command(cls=StudyScript)
@click.argument("records", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--live", type=click.IntRange(20), default=60, show_default=True, help="Live points of the sampler.")
@click.option("--simulated", type=click.IntRange(20), default=150, show_default=True, help="Records of every effect.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
def main(records: tuple[Path, ...], live: int, simulated: int, seed: int) -> None:
    """Print the diagnosis of RECORDS beside both other opinions."""
    console = wide_console(150)
    heads = ("record", "verdict", "leading", "log evidence, Laplace → sampled", "classifier")
    table = Table(*heads, box=box.SIMPLE_HEAD)
    gaps = []
    for path in records:
        try:
            one = opinion_on(path.name, diagnose(read_record(path)), live, simulated, seed)
        except WirewearError as problem:
            console.print(f"{path}: {problem}", highlight=False)
            continue
        pairs = ", ".join(f"{name} {one.laplace[name]:.1f} → {value:.1f}" for name, value in one.sampled.items())
        learned = f"{one.likeliest} {one.learned[one.likeliest]:.2f}"
        table.add_row(one.name, one.verdict, one.leading, pairs, learned)
        gaps += [value - one.laplace[name] for name, value in one.sampled.items()]
    if not table.rows:
        raise RecordError("none of these is a record that can be diagnosed.")
    console.print(table)
    if gaps:
        console.print(
            f"Sampled less Laplace's log evidence: {np.mean(gaps):+.2f} on average, at most {np.abs(gaps).max():.2f}."
        )


if __name__ == "__main__":
    main()
