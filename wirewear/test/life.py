"""The [life] table of a study: criterion of crack initiation, fatigue data, and averaging of stresses."""

from collections.abc import Mapping
from math import pi, sqrt
from typing import Annotated, Literal, Self, cast

from pydantic import Field, PlainValidator

from wirewear.base.errors import StudyError
from wirewear.base.units import Quantity
from wirewear.test import keys
from wirewear.test.materials import material_named, materials

CRITERIA = ("smith-watson-topper", "fatemi-socie", "crossland", "stress-life")
AVERAGINGS = ("volume", "line", "point")

Strength = Annotated[float, PlainValidator(Quantity("MPa", 1.0, 1e5))]
Exponent = Annotated[float, PlainValidator(Quantity("1", -2.0, -0.01))]
Positive = Annotated[float, PlainValidator(Quantity("1", 1e-4, 10.0))]
Factor = Annotated[float, PlainValidator(Quantity("1", 0.0, 10.0))]
Length = Annotated[float, PlainValidator(Quantity("um", 0.1, 5e3))]

#: Medians of steels as shares of the tensile strength and as numbers (Meggiolaro & Castro, Int. J. Fatigue 26 (2004)
#: 463, as Metals 15 (2025) 780, has them in a table), and the scatter of a life that is only estimated so.
_MEDIANS = {
    "fatigue_strength_exponent": -0.09,
    "fatigue_ductility_coefficient": 0.45,
    "fatigue_ductility_exponent": -0.59,
    "scatter_decades": 0.5,
}
ENDURANCE_cycles = 1e12  #: Where none is stated: no test has lasted so long.
TENSILE_STRENGTH = "tensile_strength_MPa"
CURVE_KEYS = (
    "fatigue_strength_coefficient_MPa", "fatigue_strength_exponent", "fatigue_ductility_coefficient",
    "fatigue_ductility_exponent",
)  # fmt: skip


class LifeTable(keys.Table):
    """Keys for the number of cycles until a crack begins; fatigue data left out are taken from the material."""

    criterion: Annotated[
        Literal["smith-watson-topper", "fatemi-socie", "crossland", "stress-life"],
        PlainValidator(keys.one_of(*CRITERIA)),
    ] = Field("smith-watson-topper", description=" or ".join(f'"{name}"' for name in CRITERIA))
    material: keys.MaterialName | None = Field(
        None, description="material of the table whose data are taken; by default that which the body names"
    )
    tensile_strength_MPa: Strength | None = Field(
        None, description="of a steel that was not tested: what else is left out is estimated from it by medians"
    )
    fatigue_strength_coefficient_MPa: Strength | None = Field(None, description="Basquin's coefficient σ_f'")
    fatigue_strength_exponent: Exponent | None = Field(None, description="Basquin's exponent b, of reversals 2N")
    fatigue_ductility_coefficient: Positive | None = Field(None, description="Coffin and Manson's coefficient ε_f'")
    fatigue_ductility_exponent: Exponent | None = Field(None, description="Coffin and Manson's exponent c")
    yield_strength_MPa: Strength | None = Field(None, description="cyclic yield strength, of Fatemi and Socie")
    fatemi_socie_factor: Factor | None = Field(
        None, description="Fatemi and Socie's k, with the yield strength; without them k/σ_y is 1/σ_f'"
    )
    fatigue_limit_MPa: Strength | None = Field(None, description="amplitude of the fatigue limit, tension, R = -1")
    torsion_fatigue_limit_MPa: Strength | None = Field(None, description="the same in torsion")
    crossland_slope: Factor | None = Field(
        None, description="weight of the hydrostatic stress; without it that of both fatigue limits, or 0.3"
    )
    endurance_cycles: Annotated[float, PlainValidator(Quantity("cycles", 1.0, 1e15))] = Field(
        ENDURANCE_cycles, description="stresses under which lives are longer do no damage, and a life is endless"
    )
    threshold_MPa_sqrt_m: Annotated[float, PlainValidator(Quantity("MPa_sqrt_m", 0.1, 100.0))] | None = Field(
        None, description="range of the stress intensity at the threshold, R = -1"
    )
    grain_um: Length | None = Field(None, description="size of a grain: stresses are averaged over it, if nothing else")
    averaging: Annotated[Literal["volume", "line", "point"], PlainValidator(keys.one_of(*AVERAGINGS))] = Field(
        "volume", description=" or ".join(f'"{name}"' for name in AVERAGINGS) + ": how critical distances are taken"
    )
    critical_distance_um: Length | None = Field(
        None, description="critical distance L; without it El Haddad's, of threshold and fatigue limit"
    )
    averaging_length_um: Length | None = Field(
        None, description="stresses are averaged over balls, or discs, of this diameter instead"
    )
    scatter_decades: Annotated[float, PlainValidator(Quantity("1", 0.0, 3.0))] | None = Field(
        None, description="standard deviation of the decimal logarithm of lives; 0.2 by default, of medians 0.5"
    )

    def of_material(self, named: str | None) -> Self:
        """A copy completed with the fatigue data of the material it names or, if it names none, of `named`; of neither
        if both are None. A tensile strength without curve data adds medians for steel.
        """
        name = self.material or named
        known = {} if name is None else {"material": name, **dict(material_named(name).fatigue)}
        stated = known | self.model_dump(exclude_none=True, exclude_unset=True)
        strength = stated.get(TENSILE_STRENGTH)
        if strength is not None and not any(stated.get(key) for key in CURVE_KEYS):
            estimated = {CURVE_KEYS[0]: 1.5 * float(cast("float", strength)), **_MEDIANS}
            stated = estimated | stated
        return self.model_validate(stated)

    def required(self, *names: str) -> tuple[float, ...]:
        """Values of the keys `names`, in their order and units. Raises StudyError if one is not stated."""
        lacking = [name for name in names if getattr(self, name) is None]
        if lacking:
            known = ", ".join(item.name for item in materials() if item.fatigue)
            raise StudyError(
                f"a life by {self.criterion} needs {', '.join(lacking)}: state them in [life] of the study, or with "
                f"--set KEY=VALUE, or take the data of a material with --material ({known})."
            )
        return tuple(float(getattr(self, name)) for name in names)

    @property
    def needed(self) -> tuple[str, ...]:
        """Keys that must be stated for this criterion and averaging."""
        found: tuple[str, ...] = CURVE_KEYS[:2] if self.criterion in ("crossland", "stress-life") else CURVE_KEYS
        if self.criterion == "fatemi-socie" and self.fatemi_socie_factor is not None:
            found += ("yield_strength_MPa",)
        if self.criterion == "crossland" and self.crossland_slope is None and self.torsion_fatigue_limit_MPa:
            found += ("fatigue_limit_MPa",)
        if self.averaging_length_um is None and self.critical_distance_um is None:
            if self.threshold_MPa_sqrt_m:
                found += ("fatigue_limit_MPa",)
            elif self.averaging != "volume":
                found += ("critical_distance_um",)
        return tuple(dict.fromkeys(found))

    @property
    def slope(self) -> float:
        """Crossland's weight of the hydrostatic stress: as stated, or of both fatigue limits, or 0.3."""
        if self.crossland_slope is not None:
            return self.crossland_slope
        if self.fatigue_limit_MPa is None or self.torsion_fatigue_limit_MPa is None:
            return 0.3
        return max(3.0 * (self.torsion_fatigue_limit_MPa / self.fatigue_limit_MPa - sqrt(1.0 / 3.0)), 0.0)

    @property
    def distance_um(self) -> float:
        """Critical distance: as stated, or El Haddad's (ΔK / Δσ)² / π (Int. J. Fract. 16 (1980) 15); 0 if unknown."""
        if self.critical_distance_um is not None:
            return self.critical_distance_um
        if self.threshold_MPa_sqrt_m is None or self.fatigue_limit_MPa is None:
            return 0.0
        return float(1e6 / pi * (self.threshold_MPa_sqrt_m / (2.0 * self.fatigue_limit_MPa)) ** 2)

    @property
    def scatter(self) -> float:
        """Standard deviation of the decimal logarithm of lives; 0.2 if not stated."""
        # Where none is stated.
        return 0.2 if self.scatter_decades is None else self.scatter_decades


def material_of_body(tables: Mapping[str, object], body: str) -> str | None:
    """Name of the material of the body called `body` in the nested tables of a study, or the one stated for both wires;
    None if constants are stated instead.
    """
    for holder in (tables, *(one for one in tables.values() if isinstance(one, Mapping))):
        own = holder.get(body)
        if isinstance(own, Mapping) and own.get("material"):
            return str(own["material"])
    shared = tables.get("wires", {})
    return shared.get("material") if isinstance(shared, Mapping) else None
