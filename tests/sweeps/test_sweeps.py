"""Sweeps: designs, studies of their runs, rows that are never lost, one table whoever makes it."""

import math
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit

from tests.browser import page_faults
from tests.studies import COARSE, WEARING, line_study
from tests.sweeps.in_place import InPlace
from wirewear import lives
from wirewear.base.engine import Engine
from wirewear.base.errors import RunError, StudyError
from wirewear.simulation import simulate
from wirewear.sweeps import Sweep, load_sweep, run_sweep
from wirewear.sweeps.indices import indices
from wirewear.sweeps.running import JOURNAL
from wirewear.sweeps.sweep import Design, SweepRow, VariedInput, figures_named, run_case
from wirewear.views.sweep_page import front, lines_through, write_sweep, write_table

HEAD = 'format = 1\nname = "a sweep"\nstudy = "study.toml"\n'
STIFFNESS = '[[vary]]\nkey = "holder.tangential_stiffness_N_per_mm"\nlow = 50.0\nhigh = 5000.0\nscale = "logarithmic"\n'
FRICTION = '[[vary]]\nkey = "contact.friction"\nlow = 0.3\nhigh = 0.8\n'
PLAY = '[[vary]]\nkey = "effects.free_play.gap_um"\nlow = 0.5\nhigh = 3.0\n'
HYPERCUBE = 'design = "latin-hypercube"\nsamples = 12\n'


def spring_loop(study: object, values: dict[str, float], fidelity: str, number: int, results: Path | None) -> SweepRow:
    """A row by the closed form of a rig's first loop: a spring of the rig's stiffness under Coulomb's friction."""
    stiffness, friction = values["holder.tangential_stiffness_N_per_mm"], values["contact.friction"]
    if friction > 0.7:
        return SweepRow(number, None, "the contact did not converge", 1.0, 1)
    figures: dict[str, float | None] = dict.fromkeys(figures_named(("moving", "fixed")))
    figures["max_tangential_force_N"] = 2.0 * friction
    figures["slip_amplitude_um"] = 20.0 - 2e3 * friction / stiffness
    figures["max_depth_fixed_um"] = friction
    return SweepRow(number, figures, "", 2.0, 10**6)


@pytest.fixture
def sweep_file(tmp_path: Path) -> Callable[[str], Path]:
    def written(text: str) -> Path:
        (tmp_path / "study.toml").write_text(COARSE + WEARING + "[holder]\ntangential_stiffness_N_per_mm = 300.0\n")
        path = tmp_path / "sweep.toml"
        path.write_text(HEAD + text)
        return path

    return written


@pytest.fixture
def asked(sweep_file: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch) -> Sweep:
    monkeypatch.setattr("wirewear.sweeps.running.run_case", spring_loop)
    return load_sweep(sweep_file(HYPERCUBE + STIFFNESS + FRICTION))


def test_what_a_run_takes_leaves_out_compiling_which_later_runs_are_spared(monkeypatch: pytest.MonkeyPatch) -> None:
    def compiling(*_: object, **__: object) -> None:
        njit(lambda x: x.sum())(np.ones(2))
        raise RunError("nothing but compiled")

    monkeypatch.setattr("wirewear.sweeps.sweep.simulate", compiling)
    started = time.process_time()
    row = run_case(line_study(), {}, "quick", 1, None)
    assert row.failure == "nothing but compiled"
    assert 0.0 < row.cpu_s < 0.3 * (time.process_time() - started)


def files(folder: Path, sweep: Sweep, engine: Engine) -> dict[str, bytes]:
    paths = write_table(folder, sweep, run_sweep(sweep, folder, engine).rows)
    return {path.name: path.read_bytes() for path in paths}


@pytest.mark.seconds
def test_the_page_of_a_sweep_fits_every_screen(asked: Sweep, tmp_path: Path) -> None:
    *_, page = write_sweep(tmp_path, run_sweep(asked, tmp_path / "runs", InPlace()))
    assert page_faults(page) == []


# Designs


def test_a_grid_has_every_combination(sweep_file: Callable[[str], Path]) -> None:
    sweep = load_sweep(
        sweep_file(
            'design = "grid"\n[[vary]]\nkey = "contact.friction"\nvalues = [0.3, 0.6]\n'
            '[[vary]]\nkey = "conditions.normal_load_N"\nvalues = [1.0, 2.0, 4.0]\n'
        )
    )
    assert len({tuple(point) for point in sweep.design.points.tolist()}) == len(sweep) == 6
    study = sweep.study_of(5)
    assert (study.contact.friction, study.conditions.normal_load_N) == (0.6, 4.0)


def test_a_latin_hypercube_has_one_run_in_each_slice_and_spreads_logarithms(asked: Sweep) -> None:
    for column, (low, high) in enumerate([(math.log(50.0), math.log(5000.0)), (0.3, 0.8)]):
        values = asked.design.points[:, column]
        share = ((np.log(values) if column == 0 else values) - low) / (high - low)
        assert sorted(np.floor(12 * share).astype(int)) == list(range(12))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (HYPERCUBE + FRICTION + FRICTION, "contact.friction is varied twice"),
        ('design = "latin-hypercube"\n' + FRICTION, "samples is missing"),
        ('design = "sobol"\nsamples = 12\n' + FRICTION, "a power of 2 such as"),
        ('design = "grid"\n' + FRICTION, "must give values, and no ends"),
        (HYPERCUBE + FRICTION.replace("0.8", "0.2"), "low must be below high"),
        (HYPERCUBE + FRICTION.replace("contact.friction", "contact.fricton"), "unknown key 'fricton'"),
        (HYPERCUBE + FRICTION.replace("key =", "ky ="), "unknown key 'ky' in [[vary]] number 1 of"),
        (HYPERCUBE + FRICTION.replace('key = "contact.friction"', ""), "missing key 'key' in [[vary]] number 1 of"),
        (HYPERCUBE + PLAY + FRICTION.replace("0.3", "nan"), "low in [[vary]] number 2 of"),
        (HYPERCUBE + "vary = [5]\n", "number 1 of the list in [vary] of"),
        (HYPERCUBE, "missing table [vary]"),
        (FRICTION, "missing key 'design' in"),
        (FRICTION, "give the way in which the values of the varied keys are chosen"),
        (HYPERCUBE + FRICTION.replace("0.3", "-0.3"), "sweep.toml, contact.friction = -0.3: friction in [contact]"),
        (HYPERCUBE + PLAY.replace("gap_um", "gap"), "has no parameter 'gap'"),
        (HYPERCUBE + PLAY.replace("effects.free_play.gap_um", "effects.gap"), "names no effect's parameter"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(sweep_file: Callable[[str], Path], text: str, says: str) -> None:
    with pytest.raises(StudyError, match=re.escape(says)) as refused:
        load_sweep(sweep_file(text))
    assert "\n" not in str(refused.value)


# Rows


def test_an_interrupted_sweep_goes_on_to_the_same_files_and_makes_no_run_twice(asked: Sweep, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_sweep(asked, tmp_path / "broken", InPlace(most=5))
    again = InPlace(backwards=True)
    broken = files(tmp_path / "broken", asked, again)
    assert again.started == len(asked) - 5
    assert broken == files(tmp_path / "unbroken", asked, InPlace())


def test_a_row_that_is_damaged_or_cut_off_is_made_again(asked: Sweep, tmp_path: Path) -> None:
    whole = files(tmp_path / "out", asked, InPlace())
    journal = tmp_path / "out" / JOURNAL
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text(
        "".join([*lines[:4], lines[4].replace('"number": ', '"number": 1'), *lines[5:-1], lines[-1][:40]])
    )
    again = InPlace()
    assert files(tmp_path / "out", asked, again) == whole
    assert again.started == 2


def test_a_failed_run_is_kept_apart_with_its_sentence(asked: Sweep, tmp_path: Path) -> None:
    written = files(tmp_path, asked, InPlace())
    failures = written["failures.csv"].decode().splitlines()
    wrong = int((asked.design.points[:, 1] > 0.7).sum())
    assert wrong > 0
    assert len(failures) == 1 + wrong
    assert failures[1].endswith("the contact did not converge")
    assert written["table.csv"].decode().count("failed") == wrong


def test_a_folder_of_another_sweep_is_refused(asked: Sweep, sweep_file: Callable[[str], Path], tmp_path: Path) -> None:
    run_sweep(asked, tmp_path / "out", InPlace())
    other = load_sweep(sweep_file(HYPERCUBE.replace("12", "13") + STIFFNESS + FRICTION))
    with pytest.raises(RunError, match="holds another sweep: choose another --output"):
        run_sweep(other, tmp_path / "out", InPlace())


# What it says


def test_sobol_indices_are_those_of_the_closed_form() -> None:
    """Ishigami's function with a = 7, b = 0.1 (Saltelli et al. 2008, section 4.5): S1 0.314, 0.442, 0; ST3 0.244."""
    from SALib.sample import sobol

    factors = tuple(VariedInput(key, -math.pi, math.pi, False) for key in "abc")
    design = Design("sobol", factors, np.empty(0), np.empty(0))
    shares = sobol.sample(design.problem, 1024, calc_second_order=False, seed=3)
    x = -math.pi + 2.0 * math.pi * shares
    values = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    rows = {n + 1: SweepRow(n + 1, {"slip": float(value)}) for n, value in enumerate(values)}
    # A failed run takes its block along and spoils nothing.
    rows[7] = SweepRow(7, None, "failed")
    found = indices(Design("sobol", factors, shares, x), rows, "slip")
    for index, first in zip(found, (0.3139, 0.4424, 0.0), strict=True):
        assert index.first == pytest.approx(first, abs=1.5 * index.first_error + 0.005)
    assert found[2].total == pytest.approx(0.2437, abs=0.03)


def test_the_front_holds_unbeaten_runs_and_lines_of_grids_pass_through_runs() -> None:
    slip, depth = np.array([1.0, 3.0, 2.0, 3.0]), np.array([1.0, 3.0, 2.5, 4.0])
    assert front(slip, depth).tolist() == [0, 2, 1]
    points = np.array([[x, z] for x in (1.0, 2.0, 3.0) for z in (0.0, 10.0)])
    y = points[:, 0] + points[:, 1]
    lines = lines_through(points, 0, y)
    assert [line[1].tolist() for line in lines] == [[1.0, 2.0, 3.0], [11.0, 12.0, 13.0]]
    scattered = np.random.default_rng(0).random((40, 2))
    assert len(lines_through(scattered, 0, scattered[:, 0])) == 1


# Whole


def test_a_line_contact_is_swept_as_any_other_contact_is() -> None:
    study = line_study(log={"loop_cycles": [1]})
    figures = run_case(study, {"contact.friction": 0.3, "conditions.cycles": 1}, "quick", 1, None).figures or {}
    assert tuple(figures) == figures_named(study.body_names)
    assert figures["max_tangential_force_N"] == pytest.approx(0.3 * study.conditions.normal_load_N, rel=1e-3)


@pytest.mark.slow
def test_a_row_has_the_life_of_the_first_body_to_crack() -> None:
    strength = {"tensile_strength_MPa": 800.0, "averaging_length_um": 40.0}
    pulled = {"bulk": {"axial_stress_MPa": 300.0, "axial_stress_amplitude_MPa": 300.0}}
    asked = {"displacement_amplitude_um": 1.5, "cycles": 1}
    own: dict[str, Any] = {"wear": None, "log": {"loop_cycles": [1]}, "specimen": pulled, "conditions": asked}
    study = line_study(**own, life=strength)
    figures = run_case(study, {}, "quick", 1, None).figures or {}
    assert tuple(figures) == figures_named(study.body_names, life=True)
    both = [life.cycles for life in lives(simulate(study, fidelity="quick"))]
    assert figures["cycles_to_initiation"] == pytest.approx(min(both))
    assert min(both) < max(both)
    unending = line_study(**own, life=strength | {"endurance_cycles": 1.0})
    assert (run_case(unending, {}, "quick", 1, None).figures or {})["cycles_to_initiation"] is None
