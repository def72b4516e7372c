"""Studies of line contacts: what their files may hold, what a run leaves, and how scars grow."""

from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.studies import line_study, require_equal_runs
from tests.test_simulate import Killer
from wirewear import reference
from wirewear.base.errors import RunError, StudyError
from wirewear.results import RunResult, read_result
from wirewear.simulation import run_study, simulate
from wirewear.simulation.folder import CHECKPOINT_FILE_NAME


@pytest.fixture(scope="module")
def worn() -> RunResult:
    return simulate(line_study(), fidelity="quick")


@pytest.mark.parametrize(
    ("table", "values", "complaint"),
    [
        ("pad", {"radius_mm": -1.0}, r"radius_mm in \[pad\] of study.toml is -1.0, but must lie between"),
        ("pad", {"radius_um": 1.0}, r"given as radius_mm, in millimetres"),
        ("conditions", {"motion": "square"}, 'must be "triangular" or "sinusoidal"'),
        ("wear", {"pad_archard_mm3_per_N_m": 1e-5}, "a body wears by one law"),
        ("holder", {"tangential_stiffness_N_per_mm2": "soft"}, 'or "rigid"'),
    ],
)
def test_a_mistake_in_a_study_of_a_line_is_one_sentence(table: str, values: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        line_study(**{table: values})


@pytest.mark.slow
def test_a_worn_contact_is_a_segment_of_the_cylinder(worn: RunResult) -> None:
    """Oracle of line contacts in gross slip: A = 2b³/(3R), h = b²/(2R); 5 % for the elastic contact's own width."""
    pad, specimen = (worn.scar(20_000, body) for body in ("pad", "specimen"))
    exact = reference.line_contact_scar(1e-6 * (pad.area_um2 + specimen.area_um2), 6.0)
    depth = sum(np.interp(0.0, *scar.section_along_motion()) for scar in (pad, specimen))
    left, right = pad.edges_um()
    assert 1e-3 * depth == pytest.approx(exact.depth_mm, rel=0.05)
    assert 0.5e-3 * (right - left) == pytest.approx(exact.half_width_mm, rel=0.05)

    before, after = worn.evolution["max_depth_pad_um"][1:]
    assert np.log(after / before) / np.log(4.0) == pytest.approx(2.0 / 3.0, abs=0.07)


def test_archards_law_wears_what_the_energy_law_wears_at_the_same_friction() -> None:
    same = line_study(wear={"pad_energy_mm3_per_J": 0.0, "pad_archard_mm3_per_N_m": 4e-5 * 0.6})
    assert same.energy_coefficients() == pytest.approx((4e-5, 2e-5), rel=1e-12)


@pytest.mark.seconds
def test_a_run_that_was_killed_and_resumed_ends_with_the_same_result(tmp_path: Path) -> None:
    short = line_study(conditions={"cycles": 400}, log={"loop_cycles": [1, 40, 400]})
    unbroken = simulate(short, fidelity="quick")
    with pytest.raises(KeyboardInterrupt):
        run_study(short, fidelity="quick", output=tmp_path, observer_of=lambda _: nullcontext(Killer(1)))
    assert read_result(tmp_path / "result.h5").status == "running"
    (resumed,) = run_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert resumed.status == "complete"
    assert not (tmp_path / CHECKPOINT_FILE_NAME).exists()
    require_equal_runs(resumed, unbroken)
    assert unbroken.quality["volume_against_energy"] < 1e-10
    complete = (tmp_path / "result.h5").read_bytes()
    run_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert (tmp_path / "result.h5").read_bytes() == complete
    with pytest.raises(RunError, match="another study"):
        run_study(line_study(), fidelity="quick", output=tmp_path, resume=True)
