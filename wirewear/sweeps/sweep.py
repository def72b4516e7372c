"""A sweep as a value: its study, its design, and the study of each run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from wirewear.base.errors import StudyError
from wirewear.base.identity import RUN_CODE, Identity, added_code, identity_of
from wirewear.base.recognised import Held, require_no_other
from wirewear.base.toml import read_toml
from wirewear.effects import effect_named
from wirewear.study import Study, load_study
from wirewear.study.messages import validated
from wirewear.sweeps.design import Design, design_of
from wirewear.sweeps.tables import SweepTables

EFFECTS = "effects"

CODE = (*RUN_CODE, "wirewear/sweeps")


@dataclass(frozen=True, eq=False)
class Sweep:
    """A study without variants, and the runs that are made of it.

    name: its title.  fidelity: of every run.  keep_results: whether each run's result file is kept.
    """

    name: str
    study: Study
    design: Design
    fidelity: str = "quick"
    keep_results: bool = False

    def __len__(self) -> int:
        """The number of runs."""
        return len(self.design.points)

    @property
    def identity(self) -> Identity:
        """Of all its rows: sweeps of one identity have the same table."""
        asked = {
            "study": self.study.resolved(),
            "fidelity": self.fidelity,
            "keys": self.design.keys,
            "points": self.design.points.tolist(),
        }
        added = added_code([*self.study.effects, self.study.contact.friction_law])
        return identity_of(asked, CODE, {"added": added})

    def study_of(self, place: int) -> Study:
        """The study of a run.

        Raises:
            StudyError: there is no such key, or its value cannot be.
        """
        return varied(self.study, self.design.values(place))


def load_sweep(path: str | Path) -> Sweep:
    """Read a sweep and its study, and see that its first run makes sense.

    Raises:
        StudyError: a file cannot be read, or asks for what cannot be; the message is one sentence.
    """
    path = Path(path)
    require_no_other(path, StudyError, Held.SWEEP)
    tables = validated(SweepTables, read_toml(path, StudyError, "sweep file"), str(path), StudyError)
    study = load_study(path.parent / tables.study)
    if tables.variant is not None:
        study = study.variant(tables.variant)
    else:
        study = study.alone(f'choose one by variant = "{{first}}" in {path}')
    sweep = Sweep(tables.name, study, design_of(tables, str(path)), tables.fidelity, tables.keep_results)
    _require_possible(sweep, str(path))
    return sweep


def _require_possible(sweep: Sweep, where: str) -> None:
    """See that every key can be varied as far as it is to be, the others as in the first run.

    Raises:
        StudyError: there is no such key, or one of its ends cannot be.
    """
    first = sweep.design.values(0)
    for factor in sweep.design.factors:
        for end in (factor.low, factor.high):
            try:
                varied(sweep.study, {**first, factor.key: end})
            except StudyError as problem:
                raise StudyError(f"{where}, {factor.key} = {end:g}: {problem}") from None


def varied(study: Study, values: Mapping[str, float]) -> Study:
    """The study with values named by their keys; those of effects as effects.<effect>.<parameter>.

    An effect that the study lacks comes in; of one that it has, the named parameters change.

    Raises:
        StudyError: there is no such key, or its value cannot be.
    """
    plain = {key: _whole(value) for key, value in values.items() if not key.startswith(f"{EFFECTS}.")}
    changed: defaultdict[str, dict[str, float]] = defaultdict(dict)
    for key, value in values.items():
        if key.startswith(f"{EFFECTS}."):
            effect, parameter = _effect_key(key)
            changed[effect][parameter] = value
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
        lacking = [key for key in known if key not in given]
        if lacking:
            raise StudyError(
                f"the effect {name!r} lacks {', '.join(lacking)}: state the effect in the study, or vary every one."
            )
        made.append(kind(**given))
    return study.with_effects(*before.values(), *made)


def _effect_key(key: str) -> tuple[str, str]:
    parts = key.split(".")
    if len(parts) != 3:
        raise StudyError(f"{key!r} names no effect's parameter: write effects.<effect>.<parameter>.")
    return parts[1], parts[2]


def _whole(value: float) -> float:
    """Numbers of cycles and the like must be whole in a study."""
    return int(value) if value == int(value) else value
