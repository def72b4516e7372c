"""Tiers T0 and T1: what a case changes in a finite element run, and what a rig reads of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind import generator_of
from studies.blind.generators.cases import TrueEffect, planned_cases
from studies.blind.generators.files import record_hash, record_tables, write_traceless
from studies.blind.generators.finite_element import model
from studies.blind.generators.finite_element.changes import changes_of
from studies.blind.generators.finite_element.model import FIDELITY, NUMERICS, nominal_study
from studies.blind.generators.finite_element.readings import moments, read_test
from studies.blind.generators.generator import POINT_TIERS, Generator
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import SpecimenDraw
from tests.exam.blind_batches import PlainModel
from tests.exam.finite_element_cases import a_case, a_loop, plain_nuisances
from tests.synthetic_results import bowl, result
from wirewear import read_record
from wirewear.effects import Age, ContactLaw, Loading, Seam, Specimens, applied
from wirewear.reference import gap_curvatures
from wirewear.results import RunResult
from wirewear.simulation import discretise
from wirewear.simulation.expected_contact import scar_ellipse
from wirewear.test import Study

QUIET = SpecimenDraw()


def test_scatter_multiplies_what_the_effects_have_made_of_friction_load_and_angle() -> None:
    effects = (
        TrueEffect("friction_offset", {"friction": 0.7}),
        TrueEffect("normal_load_drift", {"fraction_per_100k_cycles": -0.2}),
        TrueEffect("crossing_angle_error", {"angle_deg": 3.0}),
    )
    changes = changes_of(effects, SpecimenDraw(friction=1.01, load=0.98, angle_deg=0.5))
    late = Age(1e5, 0.0)
    assert applied(changes, Seam.CONTACT, ContactLaw(0.62), late).friction == pytest.approx(0.7 * 1.01)
    assert applied(changes, Seam.LOADING, Loading(2.0), late).normal_load_N == pytest.approx(2.0 * 0.8 * 0.98)
    assert applied(changes, Seam.SPECIMENS, Specimens(90.0), late).crossing_angle_deg == pytest.approx(93.5)


def test_the_two_tiers_differ_in_mesh_increments_and_contact_formulation() -> None:
    control, other = (nominal_study(Nominal(), plain_nuisances(), NUMERICS[tier]) for tier in ("T0", "T1"))
    assert control.contact.formulation != other.contact.formulation
    assert control.contact.primary_wire != other.contact.primary_wire
    plans = [discretise(study, FIDELITY) for study in (control, other)]
    assert plans[0].fixed != plans[1].fixed
    assert plans[0].increments_per_cycle < plans[1].increments_per_cycle


@pytest.mark.parametrize("tier", POINT_TIERS)
def test_records_of_other_contacts_state_the_bodies_of_their_runs(tier: str) -> None:
    generator = generator_of(tier)
    *_, case = planned_cases(6, 5, generator.library, generator.outside, 3, generator.nominals)
    study, tables = nominal_study(case.nominal, case.nuisances, NUMERICS["T1"]), record_tables(case)
    assert tables.contact_kind == study.contact_kind
    assert tables.bodies_of_test == study.bodies
    turned = {
        one.nominal.crossing_angle_deg for one in planned_cases(40, 5, generator.library, (), 9, generator.nominals)
    }
    assert (len(turned) > 5) == (tier == "A1") == ("crossing_angle_error" in generator.library)


def test_loops_are_logged_at_their_increments_and_at_the_times_of_the_waveform() -> None:
    case = a_case()
    nuisances = replace(case.nuisances, displacement_noise_um=0.0, force_noise_N=0.0, outlier_share=0.0)
    case = replace(case, nuisances=nuisances, effects=())
    loops = tuple(a_loop(cycle, increments=96) for cycle in (1, *nuisances.loop_cycles[0]))
    bowls = tuple(bowl(wire, 15.0, 150.0, 150.0) for wire in ("moving", "fixed"))
    test = model.logged(replace(result(), loops=loops, scars=bowls), case, 1, QUIET, np.random.default_rng(1))
    for loop in test.loops:
        assert loop.displacement_um == pytest.approx(loops[0].displacement_um)
        assert loop.tangential_force_N == pytest.approx(loops[0].tangential_force_N)
        passed = moments(loops[0], nuisances.waveform.shape())
        assert loop.time_s == pytest.approx(passed / case.nominal.frequency_Hz)


def readings(*effects: TrueEffect, draw: SpecimenDraw = QUIET) -> dict[int, tuple[Array, Array, Array]]:
    loops = [a_loop(n) for n in (1, 100, 100000)]
    nominal = Nominal()
    changes = changes_of(effects, draw)
    return dict(read_test(loops, changes, effects, nominal, plain_nuisances(), draw, loops[0].time_s))


def test_sensors_read_gain_coupling_crosstalk_and_zero_errors() -> None:
    plain = readings()[100000]
    assert readings(TrueEffect("displacement_gain", {"gain": 1.1}))[100000][0] == pytest.approx(1.1 * plain[0])
    mixed = readings(TrueEffect("force_crosstalk", {"coefficient": 0.02}))[100000]
    assert mixed[1] == pytest.approx(plain[1] + 0.02 * plain[2])
    offset = readings(draw=SpecimenDraw(displacement_zero_um=0.4, force_zero_N=0.01))[100000]
    assert offset[0] == pytest.approx(plain[0] + 0.4)
    assert offset[1] == pytest.approx(plain[1] + 0.01)


def a_run(study: Study, _name: str) -> RunResult:
    """What a run of the study might have left: trapezoids whose height follows friction and load, and round scars."""
    late = Age(float(study.conditions.cycles), 0.0)
    friction = applied(study.effects, Seam.CONTACT, ContactLaw(study.contact.friction), late).friction
    load = applied(study.effects, Seam.LOADING, Loading(study.conditions.normal_load_N), late).normal_load_N
    amplitude = study.conditions.displacement_amplitude_um
    loops = tuple(
        replace(loop, displacement_um=loop.displacement_um * amplitude / 60.0)
        for loop in (a_loop(cycle, height_N=friction * load) for cycle in study.log.loop_cycles)
    )
    scars = tuple(bowl(wire, 15.0, 150.0, 150.0, cycle=study.conditions.cycles) for wire in ("moving", "fixed"))
    return replace(result(), loops=loops, scars=scars)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("tier", ["T0", "T1"])
def test_records_of_finite_elements_are_read_without_a_remark(
    tier: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(model, "run", a_run)
    monkeypatch.setattr(IndependentModel, "sized", lambda _self, case: ({"height": float(len(case.effects))}, 0.0))
    generator = generator_of(tier)
    for case in planned_cases(3, 2, generator.library, generator.outside):
        made = generator.make(case)
        assert made.nuisances.drive == "stroke"
        assert made.nuisances.samples == NUMERICS[tier].increments_per_cycle
        assert made.gap_in_scatter == len(case.effects)
        assert {loop.repeat for loop in made.record.loops} == set(range(1, made.nuisances.repeats + 1))
        write_traceless(tmp_path / case.name, made.record)
        record = read_record(tmp_path / case.name)
        assert record.notes == ()
        assert record.tables.conditions.drive == "stroke"
        assert {loop.cycle for loop in record.loops} == set().union(*made.nuisances.loop_cycles)
        assert len({loop.tangential_force_N.tobytes() for loop in record.loops}) == len(record.loops)


@pytest.mark.parametrize("angle_deg", [15.0, 60.0, 90.0])
def test_a_map_reaches_as_far_as_the_scar_of_wires_at_any_angle(angle_deg: float) -> None:
    wires = Nominal(crossing_angle_deg=angle_deg)
    radius, half = 0.5 * wires.diameter_mm, wires.expected_scar_mm
    gap = gap_curvatures((0.0, 1.0 / radius), (0.0, 1.0 / radius), np.radians(angle_deg))
    scar = scar_ellipse(0.25 * np.pi * half**4 / radius, gap)
    assert wires.scar_reach_mm == pytest.approx((scar.reach(0.0), scar.reach(0.5 * np.pi)))


LAST_DIGITS = slice(9, None, 7)


def metadata(folder: Path) -> list[float]:
    """All that can be seen of a record without looking at what was measured."""
    features: list[float] = [len(folder.name), int(folder.name.split("_")[1]), folder.stat().st_mtime]
    for name in ("experiment.toml", "loops.csv", "evolution.csv", "scar_moving.csv", "scar_fixed.csv"):
        path = folder / name
        if not path.exists():
            features += [0.0] * 7
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        fields = [field for line in lines[1:200] for field in line.split(",")]
        decimals = [len(field.partition(".")[2]) for field in fields]
        last_digits = [int(field[-1]) for field in fields if field[-1:].isdigit()]
        size, times = path.stat().st_size, path.stat().st_mtime
        features += [size, size / len(lines), times, len(lines), float(np.mean(decimals)), max(map(len, lines))]
        features.append(float(np.mean(np.array(last_digits) % 5 == 0)))
    return features


@pytest.mark.parametrize(
    "model",
    [PlainModel(), pytest.param(IndependentModel(points=6), marks=pytest.mark.slow)],
    ids=["plain", "independent"],
)
def test_files_have_the_same_sizes_names_times_and_widths_with_a_strong_effect_as_without_one(
    model: Generator, tmp_path: Path
) -> None:
    case = planned_cases(4, 1, model.library, model.outside)[0]
    strong = (TrueEffect("friction_offset", {"friction": 1.5 * case.nominal.friction}),)
    for name, effects in (("without", ()), ("with", strong)):
        write_traceless(tmp_path / name / case.name, model.make(replace(case, effects=effects)).record)
    without, with_effect = (np.array(metadata(tmp_path / name / case.name)) for name in ("without", "with"))
    assert record_hash(tmp_path / "without" / case.name) != record_hash(tmp_path / "with" / case.name)
    without[LAST_DIGITS] = with_effect[LAST_DIGITS] = 0.0
    assert without.tolist() == with_effect.tolist()
