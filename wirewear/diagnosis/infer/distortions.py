"""How much a record speaks for each family, beside no effect and beside those that explain it best.

A family's unknowns are normal deviates times one of a few sizes, so that its evidence stands in closed form once the
explanation beside it is taken as linear: residuals r ~ N(0, 1 + J Jᵀ + s² C Cᵀ), J of the effect's parameters, C of the
family. Many directed tests, each sharp, see what one blunt test of all residuals does not (Anau Montel, Alvey and
Weniger, Phys. Rev. D 111 (2025) 083013).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wirewear.diagnosis.infer.family_columns import SIZES, columns_of
from wirewear.diagnosis.infer.inference import Fit, Problem, jacobian_of
from wirewear.diagnosis.infer.shapes import Family
from wirewear.diagnosis.model.setup import Array


@dataclass(frozen=True, eq=False)
class Distortion:
    """One family beside one explanation.

    Attributes:
        family, beside: both.
        log_evidence: of both together, on the scale of the fits'.
        gain: by which the family raises that of the explanation alone.
        size: the likeliest of `SIZES`.
        unknowns: (k,) the family's best, in units of its columns.
        observed: (n,) what it changes of the observables at that.
        over_time: logarithms of cycles (j,) and values there (j,) of what changes in time; empty for shapes.
        deviations: how many standard deviations it stands from nothing: sqrt of what it takes from χ².
    """

    family: Family
    beside: Fit
    log_evidence: float
    gain: float
    size: float
    unknowns: Array
    observed: Array
    over_time: tuple[Array, Array]
    deviations: float


def distortions(problem: Problem, fits: Sequence[Fit]) -> tuple[Distortion, ...]:
    """All families beside each of some explanations, the most telling first."""
    found = [one for fit in fits for one in _beside(problem, fit)]
    return tuple(sorted(found, key=lambda one: -one.log_evidence))


def _beside(problem: Problem, fit: Fit) -> list[Distortion]:
    jacobian = jacobian_of(problem, fit)
    residual = problem.whitened(fit.setup) - jacobian @ fit.coordinates
    alone = _log_evidence(residual, jacobian)
    found = []
    for sets in columns_of(problem, fit.setup):
        family = sets[0].family
        tried = [(one, problem.whitening @ one.observed, size) for one in sets for size in SIZES]
        # The model moves by the columns, the residual against them.
        logs = [_log_evidence(residual, np.column_stack([jacobian, size * white])) for _, white, size in tried]
        beliefs = [np.log(one.weight / len(SIZES)) for one, _, _ in tried]
        total = float(np.logaddexp.reduce(np.add(logs, beliefs))) - family.allowed
        columns, white, size = tried[int(np.argmax(np.add(logs, beliefs)))]
        both = np.column_stack([-jacobian, size * white])
        best = np.linalg.solve(both.T @ both + np.eye(both.shape[1]), both.T @ residual)
        unknowns: Array = np.asarray(size * best[jacobian.shape[1] :], dtype=np.float64)
        found.append(
            Distortion(
                family=family,
                beside=fit,
                # The fit's own evidence is not linear: only what the family adds is taken from here.
                log_evidence=fit.log_evidence + total - alone,
                gain=total - alone,
                size=size,
                unknowns=unknowns,
                observed=columns.observed @ unknowns,
                over_time=(columns.knots, columns.of_unknowns @ unknowns if columns.knots.size else np.zeros(0)),
                deviations=_deviations(residual, jacobian, both),
            )
        )
    return found


def _log_evidence(residual: Array, columns: Array) -> float:
    """Of residuals (m,) that are normal deviates beside columns (m, k) times others, but for a constant."""
    inner = columns.T @ columns + np.eye(columns.shape[1])
    along = columns.T @ residual
    squares = float(residual @ residual - along @ np.linalg.solve(inner, along))
    return -0.5 * squares - 0.5 * float(np.linalg.slogdet(inner)[1])


def _deviations(residual: Array, jacobian: Array, both: Array) -> float:
    def squares(columns: Array) -> float:
        inner = columns.T @ columns + np.eye(columns.shape[1])
        along = columns.T @ residual
        return float(along @ np.linalg.solve(inner, along))

    return float(np.sqrt(max(squares(both) - squares(jacobian), 0.0)))


def gains_of(found: Sequence[Distortion]) -> dict[tuple[str, ...], list[float]]:
    """What each family that counts adds to the log evidence of each explanation beside which it was tried, by names."""
    gains: dict[tuple[str, ...], list[float]] = {}
    for one in found:
        if not one.family.counts:
            continue
        gains.setdefault(one.beside.names, []).append(one.gain)
    return gains
