"""Several contacts on one wire: how it shares the load among them."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from wirewear.base.errors import StudyError
from wirewear.sweeps.shared_load import SharedLoad, beam_loads, shared_load
from wirewear.test import Study
from wirewear.test.any_study import value_at
from wirewear.test.many_contacts import ManyContacts, many_contacts
from wirewear.test.study import load_study
from wirewear.views.contacts_page import write_contacts

STUDY = """
format = 1
name = "three"
kind = "crossed-wires"

[wires]
diameter_mm = 1.0
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3

[contact]
friction = 0.6

[conditions]
normal_load_N = 6.0
displacement_amplitude_um = 20.0
frequency_Hz = 3.0
cycles = 3600

[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
moving_share = 0.5
"""
THREE = "".join(f"\n[[contacts]]\nat_mm = {at}\n" for at in (-4.0, 0.0, 4.0))


def of(text: str, folder: Path) -> ManyContacts | None:
    (path := folder / "study.toml").write_text(text)
    return many_contacts(path)


@dataclass(frozen=True)
class Analytic:
    """A contact of Hertz' law whose depth grows as the root of the work done on it."""

    softness: float = 1.5e-3
    wear: float = 2e-5

    def __call__(self, study: Study, _label: str) -> SimpleNamespace:
        blocks = [(block.cycles, block.conditions["normal_load_N"]) for block in study.tables.programme]
        ends = np.cumsum([cycles for cycles, _ in blocks])
        work = np.cumsum([cycles * load for cycles, load in blocks])
        depth = self.wear * np.sqrt(work) * (0.0 if study.wear is None else 1.0)
        approach = self.softness * np.array([load for _, load in blocks]) ** (2 / 3) + depth
        forces = [
            SimpleNamespace(cycle=end, holder_z_um=np.array([0.0, -1e3 * each]), drive_um=np.array([5.0, 0.0]))
            for end, each in zip(ends, approach, strict=True)
        ]
        columns = {"cycle": ends}
        for body in ("moving", "fixed"):
            columns |= {f"max_depth_{body}_um": 5e2 * depth, f"worn_volume_{body}_mm3": 1e-6 * work}
        return SimpleNamespace(contact_forces=forces, evolution=columns, bodies=("moving", "fixed"))


def shared(text: str, folder: Path, contact: Analytic = Analytic()) -> SharedLoad:
    test = of(text, folder)
    assert test is not None
    return shared_load(test, contact)  # type: ignore[arg-type]


def test_a_wire_over_three_springs_carries_as_the_closed_form_says() -> None:
    places, load, stiffness, bending, span = np.array([-4.0, 0.0, 4.0]), 6.0, 800.0, 10308.0, 8.0
    found = beam_loads(places, load, (0.0,), bending, lambda force: force / stiffness, np.full(3, 2.0))
    flexibility = span**3 / (48.0 * bending)
    middle = load * (flexibility + 0.5 / stiffness) / (flexibility + 1.5 / stiffness)
    np.testing.assert_allclose(found, [(load - middle) / 2, middle, (load - middle) / 2], rtol=1e-9)
    assert found.sum() == pytest.approx(load, rel=1e-9)


def test_many_crossings_carry_as_a_beam_of_finite_elements_on_springs() -> None:
    places, loads, stiffness, bending = np.array([-9.0, -4.0, 0.0, 3.5, 8.0]), (-2.0, 6.0), 800.0, 10308.0
    found = beam_loads(places, 10.0, loads, bending, lambda force: force / stiffness, np.full(5, 2.0))
    nodes = np.unique([*places, *loads])
    matrix, force = np.zeros((2 * len(nodes), 2 * len(nodes))), np.zeros(2 * len(nodes))
    for k, length in enumerate(np.diff(nodes)):
        a, b = 6.0 * length, length**2
        block = np.array([[12, a, -12, a], [a, 4 * b, -a, 2 * b], [-12, -a, 12, -a], [a, 2 * b, -a, 4 * b]])
        matrix[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += bending / length**3 * block
    held, pressed = (2 * np.searchsorted(nodes, each) for each in (places, loads))
    matrix[held, held] += stiffness
    force[pressed] = 5.0
    np.testing.assert_allclose(found, stiffness * np.linalg.solve(matrix, force)[held], rtol=1e-8)


def test_a_symmetric_wire_wears_symmetrically_and_its_middle_hands_load_on(tmp_path: Path) -> None:
    found = shared(STUDY + THREE, tmp_path)
    np.testing.assert_allclose(found.load_N[0], found.load_N[2], rtol=1e-9)
    np.testing.assert_allclose(found.load_N.sum(axis=0), 6.0, rtol=1e-9)
    assert found.load_N[1, 0] > found.load_N[0, 0]
    assert (np.diff(found.load_N[1]) < 0.0).all(), "the middle wears most and sheds load"
    deflection = found.approach_um[1] - found.approach_um[0]
    expected = (6.0 - found.load_N[1]) * 8.0**3 / (48.0 * found.test.bending_stiffness_N_mm2)
    np.testing.assert_allclose(deflection, 1e3 * expected, rtol=0.05)


@pytest.mark.seconds
def test_the_page_of_contacts_shows_their_loads_and_leads_to_their_runs(tmp_path: Path) -> None:
    page = write_contacts(shared(STUDY + THREE, tmp_path), tmp_path / "out").read_text(encoding="utf-8")
    assert page.count('href="contact-1/report.html"') == 2
    assert 'href="contact-2/report.html"' in page
    assert len((tmp_path / "out" / "contacts.csv").read_text(encoding="utf-8").splitlines()) == 1 + 3 * 6


def test_two_contacts_far_apart_are_two_runs_under_half_the_load(tmp_path: Path) -> None:
    two = "\n[[contacts]]\nat_mm = -200.0\n\n[[contacts]]\nat_mm = 200.0\n"
    found = shared(STUDY + two, tmp_path)
    np.testing.assert_allclose(found.load_N, 3.0, rtol=1e-9)
    assert found.runs[0] is found.runs[1], "equal contacts are run once"


def test_a_contact_that_wears_faster_unloads(tmp_path: Path) -> None:
    stated = THREE.replace("at_mm = 0.0", "at_mm = 0.0\nwear = { energy_wear_coefficient_mm3_per_J = 3e-4 }")

    def contact(study: Study, label: str) -> SimpleNamespace:
        alpha = value_at(study.tables, "wear.energy_wear_coefficient_mm3_per_J")
        return replace(Analytic(), wear=2e-5 * (alpha / 3e-5) ** 0.5)(study, label)

    found = shared(STUDY + stated, tmp_path, contact)  # type: ignore[arg-type]
    alike = shared(STUDY + THREE, tmp_path).load_N[1]
    assert alike[-1] - found.load_N[1, -1] > 3.0 * (alike[0] - alike[-1]), "it hands on more than one that wears alike"
    np.testing.assert_allclose(found.load_N[0], found.load_N[2], rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("at_mm = 4.0", "at_mm = 0.5"), "closer than 2 mm"),
        (("cycles = 3600", "cycles = 3600\nheld_slip_amplitude_um = 5.0"), "held_slip_amplitude_um"),
        (("[contact]", "[holder]\ntangential_stiffness_N_per_mm = 100.0\n[contact]"), "rigid"),
        (("at_mm = 4.0", "at_mm = 4.0\nload_N = 3"), "load_N"),
    ],
)
def test_what_does_not_go_with_several_contacts_is_refused(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    with pytest.raises(StudyError, match=says):
        of((STUDY + THREE).replace(*change), tmp_path)


def test_what_takes_one_contact_says_who_takes_several(tmp_path: Path) -> None:
    (path := tmp_path / "study.toml").write_text(STUDY + THREE)
    with pytest.raises(StudyError, match="which wirewear run takes"):
        load_study(path)


def test_a_contact_that_lifts_off_is_named(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="lifts off"):
        shared(STUDY + THREE + "\n[span]\nloads_at_mm = [-4.0]\n", tmp_path)
