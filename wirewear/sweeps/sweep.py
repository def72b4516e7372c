"""A sweep as a value: its study, its design of runs (grid, Latin hypercube, or Saltelli's), and the row of each run.

A share is the position of a value between its lower end (0) and its upper end (1). A row holds the figures, numbers
with a name, of one run. The number of a run counts from 1, its index (place) from 0.
"""

import resource
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from math import exp, isfinite, log, log2, prod
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from solvers.jit_cache import working_cpu_s
from wirewear.base.cache import RUN_CODE, Identity, added_code, identity_of
from wirewear.base.errors import StudyError, WirewearError
from wirewear.base.files import read_toml
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.words import counted
from wirewear.base.writing import prepared_folder
from wirewear.effects import effect_named
from wirewear.kinds import contacts_of, load_any_study
from wirewear.results import PRESSURE_LENGTH, RESULT_FILE_NAME, RunResult, write_result
from wirewear.simulation import simulate
from wirewear.stress.life import life_of, require_life
from wirewear.sweeps.tables import GRID, LATIN_HYPERCUBE, LOGARITHMIC, SOBOL, SweepTables, Vary
from wirewear.test import LineStudy, Study
from wirewear.test.any_study import Of, alone, life_data
from wirewear.test.messages import validated

DIGITS = 12  #: Values are rounded to so many digits, so that one design is the same everywhere to the last bit.


MOST_RUNS = 1_000_000  #: Runs of a sweep: at ten seconds each, four months of a core.


#: Columns of the evolution that a row holds of the last cycle besides depths, and with FIRST before it of the first.
AT_END = (
    "max_tangential_force_N", "dissipated_energy_mJ", "slip_amplitude_um", "accumulated_energy_J",
    "contact_half_width_um", "max_pressure_MPa", "mid_stroke_pressure_MPa", "max_mean_pressure_MPa",
    "mid_stroke_mean_pressure_MPa",
)  # fmt: skip
AT_START = ("max_tangential_force_N", "dissipated_energy_mJ", "slip_amplitude_um", "max_pressure_MPa")
FIRST = "first_"
VOLUME = "worn_volume_mm3"
LIFE = "cycles_to_initiation"  #: Of the body that cracks first; none where no crack begins.
QUALITY = ("mirror_error", "energy_against_loops")
TECHNICAL = (*QUALITY, PRESSURE_LENGTH)  #: Figures that state how a run was made and measured, and not what came out.
DEPTH = "max_depth_"  #: What columns of depths begin with; then comes a body, the held one last.
_BEFORE_DEPTHS = 4  #: How many of `AT_END` stand before the depths.
EFFECTS = "effects"
CODE = (*RUN_CODE, "wirewear/sweeps", "wirewear/stress")


@dataclass(frozen=True)
class VariedInput:
    """A varied key: from `low` to `high`, spread linearly or logarithmically; on a grid, over the list `values`."""

    key: str
    low: float
    high: float
    logarithmic: bool
    values: tuple[float, ...] = ()

    def at(self, share: float) -> float:
        """Value at a share of the way from the lower to the upper end, rounded to DIGITS significant digits."""
        if self.logarithmic:
            value = exp(log(self.low) + share * log(self.high / self.low))
        else:
            value = self.low + share * (self.high - self.low)
        return float(f"{value:.{DIGITS}g}")


@dataclass(frozen=True, eq=False)
class Design:
    """The n runs over d varied keys. kind: "grid", "latin-hypercube" or "sobol"; factors: the keys; points (n, d):
    their values; shares (n, d): positions of these between the keys' ends.
    """

    kind: str
    factors: tuple[VariedInput, ...]
    shares: Array
    points: Array

    @property
    def keys(self) -> tuple[str, ...]:
        return tuple(factor.key for factor in self.factors)

    @cached_property
    def problem(self) -> dict[str, object]:
        """Description of the varied keys, in shares, as SALib expects it."""
        count = len(self.factors)
        return {"num_vars": count, "names": list(self.keys), "bounds": [[0.0, 1.0]] * count}

    def values(self, place: int) -> dict[str, float]:
        """Values of the varied keys in the run of index `place`, by key."""
        return dict(zip(self.keys, self.points[place].tolist(), strict=True))


def design_of(tables: SweepTables, where: str) -> Design:
    """The design that a sweep file asks for; `where` names the file in messages.

    Raises StudyError if a key is named twice, or its ends, its values or the number of samples do not suit the design.
    """
    keys = [vary.key for vary in tables.vary]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise StudyError(f"{twice} is varied twice in {where}: give it once.")
    if tables.design == GRID:
        return _grid([_of_values(vary, where) for vary in tables.vary], tables, where)
    factors = tuple(_between_ends(vary, tables.design, where) for vary in tables.vary)
    if tables.samples is None:
        raise StudyError(f"samples is missing in {where}: a design by {tables.design} needs their number.")
    runs = tables.samples * (len(factors) + 2 if tables.design == SOBOL else 1)
    _require_countable(runs, f"samples = {tables.samples}", "give fewer", where)
    shares = _drawn(tables.design, len(factors), tables.samples, tables.seed, where)
    points = np.array([[factor.at(share) for factor, share in zip(factors, row, strict=True)] for row in shares])
    return Design(tables.design, factors, shares, points)


def _drawn(kind: str, factors: int, samples: int, seed: int, where: str) -> Array:
    from scipy.stats import qmc  # It takes a quarter of a second to load.

    if kind == LATIN_HYPERCUBE:
        shares: Array = qmc.LatinHypercube(factors, rng=np.random.default_rng(seed)).random(samples)
        return shares
    if samples & (samples - 1):
        near = 2 ** round(log2(samples))
        raise StudyError(f"samples in {where} is {samples}, but Sobol's sequence takes a power of 2 such as {near}.")
    from SALib.sample import sobol

    problem = {"num_vars": factors, "names": [str(n) for n in range(factors)], "bounds": [[0.0, 1.0]] * factors}
    drawn: Array = sobol.sample(problem, samples, calc_second_order=False, seed=seed)
    return drawn


def _grid(factors: list[VariedInput], tables: SweepTables, where: str) -> Design:
    if tables.samples is not None:
        raise StudyError(f"samples in {where} does not go with a grid, whose runs follow from the values.")
    runs = prod(len(factor.values) for factor in factors)
    _require_countable(runs, "the grid", "give fewer values, or draw samples of a latin-hypercube", where)
    points = np.array(list(product(*(factor.values for factor in factors))))
    low, high = points.min(axis=0), points.max(axis=0)
    return Design(GRID, tuple(factors), (points - low) / (high - low), points)


def _require_countable(runs: int, what: str, remedy: str, where: str) -> None:
    if runs > MOST_RUNS:
        raise StudyError(
            f"{what} in {where} asks for {counted(runs)} runs, where a sweep takes at most {counted(MOST_RUNS)}: "
            f"{remedy}."
        )


def _of_values(vary: Vary, where: str) -> VariedInput:
    if vary.values is None or vary.low is not None or vary.high is not None:
        raise StudyError(f"{vary.key} in {where} must give values, and no ends, as the design is a grid.")
    return VariedInput(vary.key, min(vary.values), max(vary.values), vary.scale == LOGARITHMIC, vary.values)


def _between_ends(vary: Vary, kind: str, where: str) -> VariedInput:
    if vary.low is None or vary.high is None or vary.values is not None:
        raise StudyError(f"{vary.key} in {where} must give low and high, and no values, as the design is {kind}.")
    if not vary.low < vary.high:
        raise StudyError(f"{vary.key} in {where} goes from {vary.low:g} to {vary.high:g}: low must be below high.")
    if vary.scale == LOGARITHMIC and vary.low <= 0.0:
        raise StudyError(f"{vary.key} in {where} begins at {vary.low:g}, where a logarithmic scale needs more than 0.")
    return VariedInput(vary.key, vary.low, vary.high, vary.scale == LOGARITHMIC)


def figures_named(bodies: Sequence[str], *, life: bool = False) -> tuple[str, ...]:
    """Names of all figures of a row, in the table's order. bodies: names of the driven, then the held body. life: True
    if the study states [life], so that a row has a life, too.
    """
    depths = (f"{DEPTH}{body}_um" for body in bodies)
    at_end = (*AT_END[:_BEFORE_DEPTHS], *depths, *AT_END[_BEFORE_DEPTHS:])
    return (*at_end, VOLUME, *(f"{FIRST}{name}" for name in AT_START), *TECHNICAL, *([LIFE] if life else []))


@dataclass(frozen=True)
class SweepRow:
    """Result of one run that has ended: its figures, None for one that is not finite, or in `failure` the sentence that
    says why there are none. cpu_s (without compiling) and peak_bytes are the run's CPU time and memory.
    """

    number: int
    figures: dict[str, float | None] | None
    failure: str = ""
    cpu_s: float = 0.0
    peak_bytes: int = 0

    @property
    def failed(self) -> bool:
        return self.figures is None

    def to_json(self) -> dict[str, object]:
        """The row as plain values for JSON."""
        return dict(vars(self))


def run_case(
    study: Study | LineStudy, values: Mapping[str, float], fidelity: str, number: int, results: Path | None
) -> SweepRow:
    """Simulate the study with these values of its keys; errors of study or simulation are stated in the returned row.

    number: of the run. results: folder in which the result file is kept; None to keep none.
    """
    start_s = working_cpu_s()
    figures, failure = None, ""
    try:
        own = varied(study, values)
        result = simulate(own, fidelity=fidelity)
        figures = figures_of(result, shortest_life(own, result))
        if results is not None:
            write_result(prepared_folder(results / f"{number:06d}") / RESULT_FILE_NAME, result)
    except WirewearError as problem:
        failure = str(problem)
    except MemoryError:
        failure = "there was not enough memory"
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return SweepRow(number, figures, failure, working_cpu_s() - start_s, peak)


def shortest_life(study: Study | LineStudy, result: RunResult) -> float | None:
    """Cycles until a crack begins in the first body to crack, infinite if in none; None without [life]."""
    if study.tables.life is None:
        return None
    inside = contacts_of(result).inside
    return min(
        life_of(result, body, table, partial(inside.states, result, body), study.schedule).cycles
        for body, table in life_data(study, result.bodies).items()
    )


def figures_of(result: RunResult, life: float | None = None) -> dict[str, float | None]:
    """Figures of a finished run by name, with `life` (in cycles) if given; None for a figure that is not finite."""
    evolution = result.evolution
    names = figures_named(result.bodies, life=life is not None)
    last = {name: float(evolution[name][-1]) for name in names if name in evolution}
    first = {f"{FIRST}{name}": float(evolution[name][0]) for name in AT_START}
    volume = float(result.worn_volume_mm3[-1])
    quality = {name: float(result.quality.get(name, float("nan"))) for name in QUALITY}
    length = {PRESSURE_LENGTH: float(result.settings[PRESSURE_LENGTH])}
    found = {**last, VOLUME: volume, **first, **quality, **length} | ({} if life is None else {LIFE: life})
    return {name: found[name] if isfinite(found[name]) else None for name in names}


@dataclass(frozen=True, eq=False)
class Sweep:
    """A study without variants and the runs that are made of it. keep_results: True to keep their result files."""

    name: str
    study: Study | LineStudy
    design: Design
    fidelity: str = "quick"
    keep_results: bool = False

    def __len__(self) -> int:
        return len(self.design.points)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures in each row."""
        return figures_named(self.study.body_names, life=self.study.tables.life is not None)

    @property
    def identity(self) -> Identity:
        """Identity of the sweep's table of rows: sweeps of equal identity have equal rows."""
        asked = {
            "study": self.study.resolved(),
            "fidelity": self.fidelity,
            "keys": self.design.keys,
            "points": self.design.points.tolist(),
        }
        added = added_code([*self.study.effects, *self.study.laws])
        return identity_of(asked, CODE, {"added": added})

    def case(self, place: int) -> tuple[Study | LineStudy, dict[str, float]]:
        """(study, values of the varied keys by key) of the run of index `place`; the study is without them."""
        return self.study, self.design.values(place)

    def study_of(self, place: int) -> Study | LineStudy:
        """Study of the run of index `place`. Raises StudyError if a key does not exist, or a value is not allowed."""
        return varied(*self.case(place))


def load_sweep(path: str | Path) -> Sweep:
    """Read a sweep and its study, and check that all its keys can be varied as asked.

    Raises StudyError, in one sentence, if a file cannot be read or asks for something impossible.
    """
    path = Path(path)
    require_no_other(path, StudyError, Held.SWEEP)
    tables = validated(SweepTables, read_toml(path, StudyError, "sweep file"), str(path), StudyError)
    study = load_any_study(path.parent / tables.study, varied=True)
    if tables.variant is not None:
        study = study.variant(tables.variant)
    else:
        study = alone(study, f'choose one by variant = "{{first}}" in {path}')
    sweep = Sweep(tables.name, study, design_of(tables, str(path)), tables.fidelity, tables.keep_results)
    _require_possible(sweep, str(path))
    return sweep


def _require_possible(sweep: Sweep, where: str) -> None:
    """Check the study at both ends of every varied key, the other keys being as in the first run.

    Raises StudyError if a key does not exist, or a value is not allowed.
    """
    first = sweep.design.values(0)
    for factor in sweep.design.factors:
        for end in (factor.low, factor.high):
            try:
                study = varied(sweep.study, {**first, factor.key: end})
            except StudyError as problem:
                raise StudyError(f"{where}, {factor.key} = {end:g}: {problem}") from None
    if study.tables.life is not None:
        require_life(study, study.body_names, {})


def varied(study: Of, values: Mapping[str, float]) -> Of:
    """A copy of the study with these values by key; parameters of effects have keys effects.<effect>.<parameter>.

    An effect that the study lacks is added, if all its parameters are given; of one that it has, only the given ones
    change. Raises StudyError if a key does not exist, or a value is not allowed.
    """
    plain = {key: _whole(value) for key, value in values.items() if not key.startswith(f"{EFFECTS}.")}
    changed: defaultdict[str, dict[str, float]] = defaultdict(dict)
    for key, value in values.items():
        if key.startswith(f"{EFFECTS}."):
            parts = key.split(".")
            if len(parts) != 3:
                raise StudyError(f"{key!r} names no effect's parameter: write effects.<effect>.<parameter>.")
            changed[parts[1]][parts[2]] = value
    study = study.with_values(plain) if plain else study
    if not changed:
        return study
    before = {effect.name: effect for effect in study.effects}
    made = []
    for name, parameters in changed.items():
        kind = effect_named(name)
        known = kind.parameters()
        unknown = next((key for key in parameters if key not in known), None)
        if unknown is not None:
            raise StudyError(f"the effect {name!r} has no parameter {unknown!r}: it has {', '.join(known)}.")
        old = before.pop(name, None)
        given = {**(old.values if old is not None else {}), **parameters}
        lacking = [key for key, item in known.items() if key not in given and item.default is None]
        if lacking:
            raise StudyError(
                f"the effect {name!r} lacks {', '.join(lacking)}: state the effect in the study, or vary every one."
            )
        made.append(kind(**given))
    return study.with_effects(*before.values(), *made)


def _whole(value: float) -> float:
    """Value as an int if it is whole, as numbers of cycles must be in a study."""
    return int(value) if value == int(value) else value
