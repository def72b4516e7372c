"""A classifier of causes taught by records that the fast model made, with what it is worth on records it never saw.

Each effect of the library is drawn with all its numbers from what one expects beforehand; its change of the whitened
observables is its signal. Scatter, solver differences and noise are the covariance of the record's nominal test, so
that in whitened numbers they are independent deviates of size one, drawn anew for every example.

Signals have either sign and any size, and fill a few dozen of several hundred directions. So what is learned from are
the components within these directions, as they are, as a direction, and their length.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.infer.inference import Fit, Problem, applied
from wirewear.diagnosis.infer.weighing import PRIOR_NONE, SEPARABLE

Array = NDArray[np.float64]
Places = NDArray[np.intp]

NONE = "none"

_SPANNED = 0.9995  #: Share of the signals' directions, in the mean square, that what is learned from holds.

#: Share of the signals that is kept from learning; examples of each signal, by other noise; networks that vote.
_HELD_OUT, _EXAMPLES, _NETWORKS = 0.2, 4, 3

CLEAR = 5.0  #: Standard deviations that count as a gap that should be told.


@dataclass(frozen=True, eq=False)
class Signals:
    """Changes (k, m) of the whitened observables by effects at random sizes, `labels` (k,) are places in `names`.

    names[0] is none, of which there are no signals.
    """

    names: tuple[str, ...]
    whitened: Array
    labels: Places

    @classmethod
    def drawn(cls, problem: Problem, singles: Sequence[Fit], number: int, random: np.random.Generator) -> "Signals":
        """So many of each effect."""
        base = problem.predicted(problem.setup)
        rows = []
        for one in singles:
            size = sum(len(candidate.unknowns) for candidate in one.candidates)
            for z in random.standard_normal((number, size)):
                changed = problem.predicted(applied(one.candidates, problem.setup, z))
                rows.append(problem.whitening @ (changed - base))
        labels = np.repeat(np.arange(1, len(singles) + 1), number)
        return cls((NONE, *(one.names[0] for one in singles)), np.stack(rows), labels)

    def taken(self, some: NDArray[Any]) -> "Signals":
        """Some of them."""
        return Signals(self.names, self.whitened[some], self.labels[some])

    def directions(self) -> Array:
        """Orthonormal rows (d, m) that span nearly all of what effects do, large or small."""
        length = np.linalg.norm(self.whitened, axis=1)
        seen = length > 1.0
        if not seen.any():
            return np.eye(1, self.whitened.shape[1])
        _, sizes, rows = np.linalg.svd(self.whitened[seen] / length[seen, None], full_matrices=False)
        held = np.cumsum(sizes**2) / np.sum(sizes**2)
        return np.asarray(rows[: int(np.searchsorted(held, _SPANNED)) + 1])

    def along(self, directions: Array) -> "Signals":
        """Their components."""
        return Signals(self.names, self.whitened @ directions.T, self.labels)

    def apart(self, wanted: Array) -> Array:
        """Least distance (n, c) from wanted signals (n, m) to any of each effect's, made longer or shorter; to none."""
        length = np.linalg.norm(self.whitened, axis=1)
        unit = self.whitened / np.maximum(length, 1e-9)[:, None]
        along = np.maximum(wanted @ unit.T, 0.0)
        squares = np.maximum((wanted**2).sum(axis=1)[:, None] - along**2, 0.0)
        found = [np.sqrt(squares[:, self.labels == place].min(axis=1)) for place in range(1, len(self.names))]
        return np.column_stack([np.linalg.norm(wanted, axis=1), *found])


@dataclass(frozen=True)
class Worth:
    """How good a judge the classifier is, on signals that it never saw.

    Attributes:
        clear: records whose signal lies above `CLEAR` from none.
        named: how many of them it gives the name of the effect.
        right: how many the effect, or one that imitates it to within what can be told apart.
        small, small_right: the same of those below.
    """

    clear: int
    named: int
    right: int
    small: int
    small_right: int


@dataclass(frozen=True, eq=False)
class Classifier:
    """Networks that vote, taught in the components along `directions` (d, m)."""

    names: tuple[str, ...]
    directions: Array
    networks: tuple[Any, ...]

    def probabilities(self, whitened: Array, prior: Sequence[float] | None = None) -> Array:
        """Probability (n, c) of each name for whitened changes (n, m); all as likely before looking unless told."""
        return self._of_components(whitened @ self.directions.T, prior)

    def _of_components(self, components: Array, prior: Sequence[float] | None = None) -> Array:
        learned = np.mean([network.predict_proba(features(components)) for network in self.networks], axis=0)
        weighed = np.asarray(learned * (1.0 if prior is None else np.asarray(prior)), dtype=np.float64)
        return np.asarray(weighed / weighed.sum(axis=1, keepdims=True))

    def worth(self, held_out: Signals, known: Signals, random: np.random.Generator) -> Worth:
        """On signals along the directions that were held out, beside those that were known."""
        imitated = known.apart(held_out.whitened)
        rows = np.arange(held_out.labels.size)
        imitated[rows, held_out.labels] = 0.0
        seen = held_out.whitened + random.standard_normal(held_out.whitened.shape)
        chosen = self._of_components(seen).argmax(axis=1)
        right = imitated[rows, chosen] < SEPARABLE
        clear = imitated[:, 0] > CLEAR
        return Worth(
            clear=int(clear.sum()),
            named=int((chosen == held_out.labels)[clear].sum()),
            right=int(right[clear].sum()),
            small=int((~clear).sum()),
            small_right=int(right[~clear].sum()),
        )


def features(components: Array) -> Array:
    """What is learned from: components (n, d) with large ones by their logarithm, their direction, their length."""
    length = np.linalg.norm(components, axis=1, keepdims=True)
    direction = components / np.maximum(length, 1e-9)
    return np.hstack([np.arcsinh(components), 3.0 * direction, np.log1p(length)])


def taught(signals: Signals, seed: int) -> tuple[Classifier, Worth]:
    """A classifier of all but a part of the signals, and its worth on that part."""
    random = np.random.default_rng(seed)
    held_out = random.random(signals.labels.size) < _HELD_OUT
    directions = signals.taken(~held_out).directions()
    known, unseen = (signals.taken(some).along(directions) for some in (~held_out, held_out))
    rows, labels = _examples(known, random)
    networks = tuple(_network(rows, labels, seed + place) for place in range(_NETWORKS))
    found = Classifier(signals.names, directions, networks)
    return found, found.worth(unseen, known, random)


def beliefs(singles: Sequence[Fit]) -> list[float]:
    """Belief before looking: in none that of the diagnosis, the rest in each effect alike."""
    return [PRIOR_NONE, *[(1.0 - PRIOR_NONE) / len(singles)] * len(singles)]


def _examples(known: Signals, random: np.random.Generator) -> tuple[Array, Places]:
    """Signals several times with other noise, and none as often as an effect."""
    of_none = np.zeros((int(known.labels.size / max(len(known.names) - 1, 1)), known.whitened.shape[1]))
    signals = np.concatenate([*[known.whitened] * _EXAMPLES, *[of_none] * _EXAMPLES])
    labels = np.concatenate([*[known.labels] * _EXAMPLES, np.zeros(_EXAMPLES * len(of_none), dtype=np.intp)])
    return features(signals + random.standard_normal(signals.shape)), labels


def _network(rows: Array, labels: Places, seed: int) -> Any:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    network = MLPClassifier(
        (128, 64),
        alpha=1e-3,
        batch_size=256,
        learning_rate_init=2e-3,
        max_iter=25,
        n_iter_no_change=25,
        tol=0.0,
        random_state=seed,
    )
    with warnings.catch_warnings():
        # It learns for so many rounds and no longer: what was held out says what it is worth.
        warnings.simplefilter("ignore", ConvergenceWarning)
        return make_pipeline(StandardScaler(), network).fit(rows, labels)
