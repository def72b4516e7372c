"""Materials by name: constants with sources, wherever a study asks for them."""

import re

import pytest
from click.testing import CliRunner

from tests.studies import MINIMAL
from wirewear import StudyError
from wirewear.faces import cli
from wirewear.planar import planar_study_from_tables
from wirewear.study import parse_study, study_from_tables
from wirewear.study.materials import material_named, materials, names

NAMED = re.sub(r"youngs_modulus.*\npoissons_ratio.*\n", 'material = "Ti6Al4V"\n', MINIMAL)


def test_every_material_has_a_source_and_constants_of_a_solid() -> None:
    spelled = [name.casefold() for item in materials() for name in (item.name, *item.also)]
    assert len(spelled) == len(set(spelled))
    assert {"Ti-6Al-4V", "Inconel 600", "Inconel 690", "Zircaloy-4", "alumina", "En31", "En24"} <= set(names())
    for item in materials():
        assert len(item.source) > 10
        assert 5e4 < item.elastic.youngs_modulus_MPa < 5e5
        assert 0.2 < item.elastic.poissons_ratio < 0.4


def test_a_study_takes_a_material_by_any_of_its_names_and_reads_back_the_same() -> None:
    study, titanium = parse_study(NAMED, "study.toml"), material_named("Ti-6Al-4V").elastic
    assert study.moving_wire.material == study.fixed_wire.material == titanium
    assert study.wires.material == "Ti-6Al-4V"
    assert study_from_tables(study.resolved(), "again").resolved() == study.resolved()


def test_each_wire_and_each_planar_body_may_be_of_another_material() -> None:
    study = parse_study(MINIMAL + '[wires.fixed]\nmaterial = "alumina"\n', "study.toml")
    assert study.fixed_wire.material == material_named("alumina").elastic
    assert study.moving_wire.youngs_modulus_MPa == 210_000.0
    planar = planar_study_from_tables(
        {
            "format": 1,
            "name": "unequal",
            "kind": "cylinder-on-flat",
            "pad": {"material": "alumina", "radius_mm": 6.0},
            "specimen": {"material": "Inconel 600"},
            "conditions": {"normal_load_N_per_mm": 20.0, "displacement_amplitude_um": 25.0, "cycles": 10},
            "contact": {"friction": 0.5},
        },
        "study.toml",
    )
    assert planar.pad.elastic == material_named("alumina").elastic
    assert planar.specimen.elastic == material_named("Inconel 600").elastic


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (NAMED.replace("Ti6Al4V", "brass"), r"material in \[wires\] of study.toml is 'brass', which is in no table"),
        (NAMED.replace("Ti6Al4V", "Ti-6Al-4W"), r"did you mean 'Ti-6Al-4V'\?$"),
        (NAMED.replace("material", "poissons_ratio = 0.2\nmaterial"), r"poissons_ratio = 0.2 beside the material"),
        (MINIMAL + "[variants.a.wires]\nmaterial = 'alumina'\n", r"beside the material 'alumina', which has 416000"),
    ],
)
def test_an_unknown_material_and_one_beside_other_constants_are_refused(text: str, complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        parse_study(text, "study.toml")


def test_the_command_lists_every_material_with_its_source() -> None:
    outcome = CliRunner().invoke(cli, ["materials"])
    assert outcome.exit_code == 0, outcome.output
    assert all(name in outcome.output for name in names())
    assert "Munro" in outcome.output
