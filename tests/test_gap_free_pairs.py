"""Pairs of tests without a gap, from which sizes of solver differences are learned."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from studies.diagnosis import gap_free_pairs
from studies.diagnosis.gap_free_pairs import MOST_CYCLES, Pair, pair_of, solver_of
from tests.diagnosis_cases import nominal, record, states, tables
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.reduction import Observations, reduce


@pytest.fixture(scope="module")
def observed() -> Observations:
    """What is observed of two tests that the fast model made, without any scatter between them."""
    return reduce(record(repeats=2, scatter=0.0, cycles=(1, 10, 100, 1000, 10_000, 30_000, 100_000)))


def paired(observed: Observations, **options: bool) -> Pair:
    return pair_of("made_T1_003", "a test", states(), nominal("sensor"), observed, **options)


def smallest_share(matrix: NDArray[np.float64]) -> float:
    """The least eigenvalue over the largest."""
    values = np.linalg.eigvalsh(matrix)
    return float(values[0] / values[-1])


def test_a_record_of_the_model_itself_differs_from_it_by_noise_alone(observed: Observations) -> None:
    pair = paired(observed)
    deviates = pair.residual / np.sqrt(np.diag(pair.fixed))
    assert np.mean(deviates**2) < 1.5
    unlike = pair_of("made_T1_003", "a test", states(), replace(nominal("sensor"), friction_factor=1.1), observed)
    assert np.mean((unlike.residual / np.sqrt(np.diag(unlike.fixed))) ** 2) > 10.0


def test_a_pair_is_of_the_first_repeat_thinned_to_a_few_cycles(
    observed: Observations, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[Layout] = []
    thinned = Layout.taken

    def remembered(self: Layout, keep: NDArray[np.bool_]) -> Layout:
        taken.append(thinned(self, keep))
        return taken[-1]

    monkeypatch.setattr(Layout, "taken", remembered)
    pair = paired(observed)
    (thin,) = taken
    assert len(thin) == pair.residual.size < len(observed.layout)
    assert all(np.unique(part.sites.cycle).size <= MOST_CYCLES for part in thin)
    assert set(thin.cycle) <= set(observed.layout.cycle)
    other = replace(observed, values=observed.values[::-1], noise=observed.noise[::-1])
    assert not np.array_equal(paired(other).residual, pair.residual)


def test_covariances_are_symmetric_and_of_no_negative_variance_and_scatter_adds_to_them(observed: Observations) -> None:
    pair, scattered = paired(observed), paired(observed, scattered=True)
    for matrix in (pair.fixed, scattered.fixed, scattered.fixed - pair.fixed, *pair.parts.values()):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        assert smallest_share(matrix) > -1e-9
    assert np.trace(scattered.fixed) > np.trace(pair.fixed)
    assert pair.freedoms.shape[0] == pair.residual.size
    assert np.isfinite(pair.freedoms).all()


def test_solver_and_test_are_told_by_name_and_conditions() -> None:
    assert [solver_of(name) for name in ("a_T1_003", "b_T0", "case_001")] == ["T1", "T0", "T2"]
    name_of = gap_free_pairs.test_of
    assert name_of(tables()) == name_of(tables(friction=0.5))
    other = tables().model_copy(update={"conditions": tables().conditions.model_copy(update={"normal_load_N": 3.0})})
    assert name_of(other) != name_of(tables())
