"""Several contacts on one wire: how it shares the load among them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.commands import wirewear
from tests.studies import COARSE
from wirewear.base.errors import StudyError
from wirewear.sweeps.shared_load import SharedLoad, shared_load
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
    """Contacts of Hertz' law whose depth grows as the root of the work done on them, and which stick or slide as a
    spring of Hertz' radius does on a yielding rig.
    """

    softness: float = 1.5e-3
    wear: float = 2e-5
    spring: float = 400.0
    last: dict[str, Study] = field(default_factory=dict)

    def __call__(self, studies: Mapping[str, Study], _round: int) -> dict[str, SimpleNamespace]:
        self.last.update(studies)
        return {label: self.run(study) for label, study in studies.items()}

    def run(self, study: Study) -> SimpleNamespace:
        blocks = study.tables.programme
        cycles = np.array([block.cycles for block in blocks])
        load = np.array([block.conditions["normal_load_N"] for block in blocks])
        rig = np.array([block.holder.get("tangential_stiffness_N_per_mm", np.inf) for block in blocks])
        alpha = value_at(study.tables, "wear.energy_wear_coefficient_mm3_per_J") or 0.0
        stroke = study.conditions.displacement_amplitude_um
        work = np.cumsum(cycles * load) * alpha / 3e-5 * stroke / 20.0
        depth = self.wear * np.sqrt(work)
        approach = self.softness * load ** (2 / 3) + depth
        sticking = 1e-3 * stroke / (1.0 / rig + 1.0 / (self.spring * load ** (1 / 3)))
        ends = np.cumsum(cycles)
        forces = [
            SimpleNamespace(cycle=end, holder_z_um=np.array([0.0, -1e3 * each]), drive_um=np.array([5.0, 0.0]))
            for end, each in zip(ends, approach, strict=True)
        ]
        columns = {"cycle": ends, "max_tangential_force_N": np.minimum(study.contact.friction * load, sticking)}
        for body in ("moving", "fixed"):
            columns |= {f"max_depth_{body}_um": 5e2 * depth, f"worn_volume_{body}_mm3": 1e-6 * work}
        return SimpleNamespace(contact_forces=forces, evolution=columns, bodies=("moving", "fixed"))


def shared(text: str, folder: Path, contact: Analytic | None = None) -> SharedLoad:
    test = of(text, folder)
    assert test is not None
    return shared_load(test, contact or Analytic())  # type: ignore[arg-type]


def test_a_symmetric_wire_wears_symmetrically_and_its_middle_hands_load_on(tmp_path: Path) -> None:
    found = shared(STUDY + THREE, tmp_path)
    np.testing.assert_allclose(found.load_N[0], found.load_N[2], rtol=1e-9)
    np.testing.assert_allclose(found.load_N.sum(axis=0), 6.0, rtol=1e-9)
    assert found.load_N[1, 0] > found.load_N[0, 0]
    assert (np.diff(found.load_N[1]) < 0.0).all(), "the middle wears most and sheds load"
    deflection = found.approach_um[1] - found.approach_um[0]
    expected = (6.0 - found.load_N[1]) * (
        8.0**3 / (48.0 * found.test.bending_stiffness_N_mm2) + 8.0 / (4.0 * found.test.shear_stiffness_N)
    )
    np.testing.assert_allclose(deflection, 1e3 * expected, rtol=0.05)


@pytest.mark.seconds
def test_the_page_of_contacts_shows_their_loads_and_leads_to_their_runs(tmp_path: Path) -> None:
    page = write_contacts(shared(STUDY + THREE, tmp_path), tmp_path / "out").read_text(encoding="utf-8")
    assert page.count('href="contact-1/report.html"') == 2
    assert 'href="contact-2/report.html"' in page
    assert len((tmp_path / "out" / "contacts.csv").read_text(encoding="utf-8").splitlines()) == 1 + 3 * 7


def test_two_contacts_far_apart_are_two_runs_under_half_the_load(tmp_path: Path) -> None:
    two = "\n[[contacts]]\nat_mm = -200.0\n\n[[contacts]]\nat_mm = 200.0\n"
    found = shared(STUDY + two, tmp_path)
    np.testing.assert_allclose(found.load_N, 3.0, rtol=1e-9)
    assert found.labels == ("contact-1", "contact-1"), "equal contacts are run once"


@pytest.mark.seconds
def test_near_contacts_share_as_elements_of_the_wire_say_which_is_nearly_as_a_beam_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    near = STUDY + THREE.replace("4.0", "1.0")
    found = shared(near, tmp_path).load_N
    np.testing.assert_allclose(found[0], found[2], rtol=1e-9)
    np.testing.assert_allclose(found.sum(axis=0), 6.0, rtol=1e-9)
    monkeypatch.setattr(ManyContacts, "are_near", False)
    as_beam = shared(near, tmp_path).load_N
    np.testing.assert_allclose(found, as_beam, rtol=0.02)
    assert np.abs(found / as_beam - 1.0).max() > 1e-4


def test_a_contact_that_wears_faster_unloads(tmp_path: Path) -> None:
    stated = THREE.replace("at_mm = 0.0", "at_mm = 0.0\nwear = { energy_wear_coefficient_mm3_per_J = 3e-4 }")

    found = shared(STUDY + stated, tmp_path)
    alike = shared(STUDY + THREE, tmp_path).load_N[1]
    assert alike[-1] - found.load_N[1, -1] > 3.0 * (alike[0] - alike[-1]), "it hands on more than one that wears alike"
    np.testing.assert_allclose(found.load_N[0], found.load_N[2], rtol=1e-9)


SADDLE = """
[span]
clamped_at_mm = [0.0]
loads_at_mm = [16.0]
tension_N = 600.0
[[contacts]]
at_mm = 12.0
gap_um = 72.0
conditions = { displacement_amplitude_um = 50.0 }
[[contacts]]
at_mm = 8.0
gap_um = 38.0
conditions = { displacement_amplitude_um = 15.0 }
[[contacts]]
at_mm = 4.0
gap_um = 14.0
conditions = { displacement_amplitude_um = 5.0 }
"""


def test_the_first_contact_of_a_saddle_unloads_as_it_wears_and_the_second_takes_over(tmp_path: Path) -> None:
    """Published for stay cables in Adv. Struct. Eng. 2024, doi 10.1177/13694332241246379."""
    pulled = STUDY.replace("normal_load_N = 6.0", "normal_load_N = 13.0").replace("cycles = 3600", "cycles = 150000")
    found = shared(pulled + SADDLE, tmp_path, Analytic(softness=7e-4, wear=6e-5))
    first, second, third = found.load_N
    assert first[0] > 7.5
    assert second[0] < 0.02 * first[0]
    assert third[0] == 0.0
    assert np.isnan(found.approach_um[2, 0])
    assert (np.diff(first) < 0.0).all()
    assert second.max() > 2.5
    assert second[-1] > first[-1]
    assert (np.diff(found.depth_um) >= 0.0).all(), "what is worn off stays so"


def test_a_contact_that_stays_open_is_not_run(tmp_path: Path) -> None:
    found = shared(STUDY + THREE.replace("at_mm = 0.0", "at_mm = 0.0\ngap_um = 90.0"), tmp_path)
    assert found.labels == ("contact-1", "", "contact-1")
    np.testing.assert_allclose(found.load_N, [[3.0] * 7, [0.0] * 7, [3.0] * 7], rtol=1e-9)
    page = write_contacts(replace(found, runs={}), tmp_path / "out").read_text(encoding="utf-8")
    assert "contact-2" not in page


@pytest.mark.parametrize("amplitude_um", [20.0, 3.0])
def test_contacts_on_a_rig_that_gives_way_move_it_as_the_sum_of_their_forces_does(
    tmp_path: Path, amplitude_um: float
) -> None:
    """Sliding or sticking: the rig's travel h solves k h = Σ min(µP, s (Δ − h)), with springs s and stroke Δ."""
    stiff = 300.0
    soft = STUDY.replace("= 20.0", f"= {amplitude_um}").replace(
        "[contact]", f"[holder]\ntangential_stiffness_N_per_mm = {stiff}\n[contact]"
    )
    contact = Analytic()
    found = shared(soft + THREE, tmp_path, contact)

    def missed(travel: float) -> float:
        springs = contact.spring * load ** (1 / 3)
        return stiff * travel - float(np.minimum(0.6 * load, springs * (1e-3 * amplitude_um - travel)).sum())

    for block in range(7):
        load = found.load_N[:, block]
        travel = brentq(missed, 0.0, 1e-3 * amplitude_um)
        for study in contact.last.values():
            force = contact.run(study).evolution["max_tangential_force_N"][block]
            share = study.tables.programme[block].holder["tangential_stiffness_N_per_mm"]
            assert force / share == pytest.approx(travel, rel=0.01)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("at_mm = 4.0", "at_mm = 0.4"), "closer than 0.5 mm"),
        (("at_mm = 4.0", "at_mm = 0.6"), "wires of 1 mm overlap that cross it 0.6 mm apart"),
        (("cycles = 3600", "cycles = 3600\nheld_slip_amplitude_um = 5.0"), "held_slip_amplitude_um"),
        (("[contact]", "[holder]\nnormal_spring_stiffness_N_per_mm = 100.0\n[contact]"), "normal_spring"),
        (("at_mm = 4.0", "at_mm = 4.0\nconditions = { cycles = 3 }"), "cycles is one's own"),
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


def test_a_wire_that_tips_over_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="tips over"):
        shared(STUDY + THREE + "\n[span]\nloads_at_mm = [-6.0]\n", tmp_path)


@pytest.mark.slow
def test_contacts_are_run_again_from_where_they_stopped_and_printed_as_json(tmp_path: Path) -> None:
    (path := tmp_path / "study.toml").write_text(COARSE + "[[contacts]]\nat_mm = 0.0\n[[contacts]]\nat_mm = 2.0\n")
    words = "run", path, "--fidelity", "quick", "--output", (out := tmp_path / "out")
    first = json.loads(wirewear(*words, "--json").stdout)
    assert [row["normal_load_N"] for row in first["contacts"]] == [pytest.approx(1.0, rel=1e-9)] * 2
    kept = (out / "contact-1" / "result.h5").stat().st_mtime_ns
    assert "complete result" in wirewear(*words, code=2).output
    (out / "contacts.csv").unlink()
    assert json.loads(wirewear(*words, "--json", "--resume").stdout) == first
    assert (out / "contacts.csv").exists()
    assert (out / "contact-1" / "result.h5").stat().st_mtime_ns == kept, "it is not simulated again"
