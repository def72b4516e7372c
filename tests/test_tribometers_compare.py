"""The tribometer study's comparison: its verdicts follow the rows, either way."""

from dataclasses import replace

import pytest

from studies.tribometers import article
from studies.tribometers.article import (
    compliance_suffices,
    force_lowers_slip,
    half_is_lost,
    measured_lies_below,
    one_rig_one_stiffness,
    stiffness_comparisons,
)
from studies.tribometers.judge import Tribometer, judge
from studies.tribometers.rows import read_rows


@pytest.fixture(scope="module")
def rows() -> list[Tribometer]:
    return [judge(row) for row in read_rows(article.ROWS)]


def test_the_published_rows_bear_out_every_statement_but_two(rows: list[Tribometer]) -> None:
    """The crossed cylinders lose 2.28 and 2.56 µm more than compliance takes, and do not keep one rig stiffness."""
    comparisons = stiffness_comparisons(rows)
    assert len(comparisons) == len({item.name for item in comparisons}) == 13
    assert all(item.holds for item in comparisons)
    assert [f for f in article.FINDINGS if not f(rows).holds] == [compliance_suffices, one_rig_one_stiffness]
    assert "2.28 of 10.7 µm" in compliance_suffices(rows).evidence
    assert "2.56 of 14.3 µm" in compliance_suffices(rows).evidence
    flats = [row for row in rows if row.contact == "cylinder-on-flat"]
    assert all(finding(flats).holds for finding in article.FINDINGS)


def test_statements_fail_where_rows_contradict_them(rows: list[Tribometer]) -> None:
    first = rows[0]
    assert not measured_lies_below([replace(first, measured_stiffness_N_per_um=100.0)]).holds
    assert not half_is_lost([replace(first, lost_um=0.1 * first.displacement_amplitude_um)]).holds
    more_force = replace(first, friction_max=first.friction_max + 0.1)
    slides_more = replace(more_force, slip_amplitude_um=first.slip_amplitude_um + 1.0)
    assert not force_lowers_slip([first, slides_more]).holds
    assert not force_lowers_slip([first]).holds
    stiffer = replace(first, rig_stiffness_N_per_um=1.5 * (first.rig_stiffness_N_per_um or 0.0))
    assert not one_rig_one_stiffness([first, stiffer]).holds
