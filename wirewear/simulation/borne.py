"""The largest pressure that bodies bear at all: beyond it they flow, which elastic bodies do not show."""

from typing import Any

from wirewear.results import BORNE, BORNE_IS
from wirewear.results.scar import called
from wirewear.study import AnyStudy
from wirewear.study.life import TENSILE_STRENGTH, LifeTable

#: Hardness over yield strength, the mean pressure of full plasticity (Tabor, The Hardness of Metals (1951)), which no
#: pressure exceeds anywhere by much.
_FULLY_PLASTIC = 2.8
#: Hardness over Young's modulus of the hardest metals: a steel of 1000 HV, 9.8 GPa, has 0.047.
_HARDEST = 0.05


def borne_settings(study: AnyStudy[Any]) -> dict[str, float | str]:
    """What a result records of the pressure that the softer body of a study bears, and what that goes by.

    By the strength that its table of life states, or else by its Young's modulus alone.
    """
    life: LifeTable | None = study.tables.life
    known = LifeTable() if life is None else life.of_material(None)
    for strength, words in (
        (known.yield_strength_MPa, "yield strength"),
        (known.tensile_strength_MPa, f"{TENSILE_STRENGTH.split('_')[0]} strength"),
    ):
        if strength is not None:
            stated = f"{_FULLY_PLASTIC:g} times the {words} of {strength:g} MPa that [life] states"
            return {BORNE: _FULLY_PLASTIC * strength, BORNE_IS: stated}
    body, softest = min(study.tables.materials.items(), key=lambda one: one[1].youngs_modulus_MPa)
    modulus = softest.youngs_modulus_MPa
    unknown = (
        f"a twentieth of Young's modulus of the {called(body)}, as the hardest metals have it: no strength is stated"
    )
    return {BORNE: _HARDEST * modulus, BORNE_IS: unknown}
