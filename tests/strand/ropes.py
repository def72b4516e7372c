"""Strands and ropes whose contacts were worked out by hand and by other means, N, mm, MPa."""

from typing import Any

STEEL = {"youngs_modulus_MPa": 200_000.0, "poissons_ratio": 0.3}
_OF_CONDUCTOR = {"youngs_modulus_MPa": 207_000.0, "poissons_ratio": 0.3}


def rope(tension_N: float, bending_radius_mm: float = 500.0, friction: float = 0.15, **tables: Any) -> dict[str, Any]:
    """Tables of a rope bent to and fro."""
    conditions = {"tension_N": tension_N, "bending_radius_mm": bending_radius_mm, "cycles": 100_000}
    given = {"format": 1, "name": "rope", "wires": STEEL, "conditions": conditions, "contact": {"friction": friction}}
    return given | tables


def seven_wires(core_mm: float, lay_length_mm: float, **more: Any) -> dict[str, Any]:
    """1+6 wires of 2.9 mm under 20 kN."""
    layers = [{"wires": 6, "wire_diameter_mm": 2.9, "lay_length_mm": lay_length_mm}]
    return rope(20_000.0, core={"wire_diameter_mm": core_mm}, layers=layers, **more)


def nineteen_wires(outer_lay: str) -> dict[str, Any]:
    """1+6+12 wires under 50 kN."""
    inner = {"wires": 6, "wire_diameter_mm": 2.9, "lay_length_mm": 70}
    outer = {"wires": 12, "wire_diameter_mm": 2.9, "lay_length_mm": 130, "radius_mm": 5.95, "lay": outer_lay}
    return rope(50_000.0, core={"wire_diameter_mm": 3.14}, layers=[inner, outer])


def conductor(bending_radius_mm: float = 500.0) -> dict[str, Any]:
    """26 aluminium wires on 7 of steel."""
    return rope(
        22_000.0, bending_radius_mm, 0.5,
        wires={"youngs_modulus_MPa": 69_000.0, "poissons_ratio": 0.33, "yield_stress_MPa": 170.0},
        core={"wire_diameter_mm": 2.72, **_OF_CONDUCTOR},
        layers=[
            {"wires": 6, "wire_diameter_mm": 2.72, "lay_length_mm": 170, **_OF_CONDUCTOR},
            {"wires": 10, "wire_diameter_mm": 3.5, "lay_length_mm": 196, "lay": "left"},
            {"wires": 16, "wire_diameter_mm": 3.5, "lay_length_mm": 243},
        ],
    )  # fmt: skip


def strands_of_seven(wire_lay: str, core_lay: str = "left", **more: Any) -> dict[str, Any]:
    """7x7 under 10 kN, the strands of right lay."""
    outer = {
        "strands": 6,
        "lay_length_mm": 75,
        "core": {"wire_diameter_mm": 1.06},
        "layers": [{"wires": 6, "wire_diameter_mm": 1.0, "lay_length_mm": 24, "lay": wire_lay}],
    }
    layers = [{"wires": 6, "wire_diameter_mm": 1.06, "lay_length_mm": 26, "lay": core_lay}]
    return rope(10_000.0, core={"wire_diameter_mm": 1.12}, layers=layers, outer_strands=outer, **more)
