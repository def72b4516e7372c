"""McColl's flat diagnosed: made-up scars of known cause are found, and none where there is none."""

from pathlib import Path

import numpy as np
import pytest

from studies.mccoll2004.compare import Scar
from studies.mccoll2004.diagnose import Cause, Profile, bump, diagnosed, findings_of, fitted, picture, readings
from wirewear.cli.study_kinds import load_any_study
from wirewear.pictures.style import save
from wirewear.planar.tables import PlanarStudy

X = np.arange(-375.0, 480.0, 5.0)
FACTORS = np.array([0.6, 0.8, 1.0, 1.2, 1.4])


def parabola(depth_um: float, half_width_um: float) -> Scar:
    return Scar(X, np.maximum(depth_um * (1.0 - (X / half_width_um) ** 2), 0.0))


def wear_rate() -> Cause:
    """A worn segment of a cylinder: the depth grows as N^(2/3), the width as N^(1/3)."""
    scars = tuple(parabola(2.7 * f ** (2.0 / 3.0), 252.0 * f ** (1.0 / 3.0)) for f in FACTORS)
    return Cause("wear rate", "a factor", FACTORS, scars, 1.0)


def stroke() -> Cause:
    scars = (parabola(2.7, 240.0), parabola(2.7, 252.0), parabola(2.7, 264.0))
    return Cause("stroke", "wider", np.array([-1.0, 0.0, 1.0]), scars, 0.0)


def measured(factor: float, *, aside_um: float = 0.0, base_um: float = 0.0, seed: int = 0) -> Scar:
    """A scar of that wear rate with roughness of 0.1 µm that is alike over three points."""
    white = np.random.default_rng(seed).standard_normal(len(X) + 2)
    rough = np.convolve(white, np.full(3, 1.0 / np.sqrt(3.0)), mode="valid") * 0.1
    return Scar(X, wear_rate().depth_um(factor, X - aside_um) + base_um + rough)


@pytest.mark.parametrize("factor", [0.8, 1.3])
def test_a_wear_rate_is_found_with_an_interval_that_holds_it_wherever_the_scar_lies(factor: float) -> None:
    profile = Profile(measured(factor, aside_um=14.0))
    found = diagnosed(profile, [wear_rate(), stroke(), bump(wear_rate().scars[2])])[2]
    assert found[0].cause.name == "wear rate"
    assert found[0].fit.value == pytest.approx(factor, rel=0.03)
    assert found[0].interval95[0] <= factor <= found[0].interval95[1]
    assert found[0].fit.aside_um == pytest.approx(14.0, abs=4.0)
    assert found[0].shrink > 0.9
    judged = findings_of(profile, *diagnosed(profile, [wear_rate(), stroke(), bump(wear_rate().scars[2])])[1:])
    assert [finding.holds for finding in judged] == [True] * 4


def test_where_nothing_is_wrong_there_is_no_gap_to_shrink() -> None:
    profile, nominal, found = diagnosed(Profile(measured(1.0)), [wear_rate(), stroke(), bump(wear_rate().scars[2])])
    assert not findings_of(profile, nominal, found)[0].holds
    assert all(np.isnan(one.shrink) for one in found)
    rate = next(one for one in found if one.cause.name == "wear rate")
    assert rate.interval95[0] <= 1.0 <= rate.interval95[1]


def test_a_zero_that_is_not_known_widens_what_is_known_of_the_wear_rate() -> None:
    """A zero off by 0.15 µm looks like a wear rate of 1.1 unless it is left free."""
    scar = measured(1.0, base_um=0.15)
    held, free = (fitted(p, wear_rate(), p.everywhere).value for p in (Profile(scar), Profile(scar, free=True)))
    assert held > 1.05
    assert free == pytest.approx(1.0, abs=0.04)


def test_the_study_of_causes_is_mccolls_and_its_picture_is_drawn(tmp_path: Path) -> None:
    folder = Path(__file__).resolve().parent.parent / "studies" / "mccoll2004"
    causes, stated = (load_any_study(folder / name) for name in ("causes.toml", "study.toml"))
    assert isinstance(causes, PlanarStudy)
    assert isinstance(stated, PlanarStudy)
    assert causes.variant_names == ("wear_rate", "shorter_stroke", "longer_stroke", "third_body")
    assert (causes.pad, causes.specimen, causes.wear, causes.contact) == (
        stated.pad,
        stated.specimen,
        stated.wear,
        stated.contact,
    )
    assert set(readings()) == {"from the figure's zero", "from the untouched flat", "zero and level free"}
    profile, nominal, found = diagnosed(Profile(measured(1.2)), [wear_rate(), stroke(), bump(wear_rate().scars[2])])
    assert save(lambda: picture(profile, nominal, found), tmp_path / "diagnosis.png").stat().st_size > 10_000
