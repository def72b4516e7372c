"""What studies of line contacts and of their rigs' stiffness begin with."""

from wirewear.planar.rig_stiffness.tables import KIND as RIG_STIFFNESS_KIND
from wirewear.planar.rig_stiffness.tables import RigStiffnessStudy
from wirewear.planar.tables import KINDS, PlanarStudy
from wirewear.study.template import Template

_TITANIUM = {"youngs_modulus_MPa": 116000.0, "poissons_ratio": 0.3}

#: A titanium cylinder on a titanium flat.
LINE_CONTACT = Template(
    KINDS[0],
    PlanarStudy,
    ("pad", "specimen", "conditions", "contact", "wear", "holder", "log"),
    {
        "pad": {"radius_mm": 40.0, **_TITANIUM},
        "specimen": _TITANIUM,
        "conditions": {
            "normal_load_N_per_mm": 390.0,
            "displacement_amplitude_um": 35.0,
            "cycles": 10000,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.9},
        "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm2": "rigid"},
    },
    "A cylinder on a flat, to be changed into your line contact; everything is per mm of its length.",
)

#: The same contact behind softer and softer springs.
RIG_STIFFNESS = Template(
    RIG_STIFFNESS_KIND,
    RigStiffnessStudy,
    ("material", "conditions", "cylinder"),
    {
        "material": _TITANIUM,
        "conditions": {"displacement_amplitude_um": 35.0, "friction": 0.9},
        "cylinder": {
            "radius_mm": 40.0,
            "normal_load_N_per_mm": 390.0,
            "pad_height_mm": 3.5,
            "pad_half_width_mm": 10.0,
            "specimen_height_mm": 3.5,
            "specimen_half_width_mm": 10.0,
            "pivot_height_mm": 10.3,
            "tangential_stiffness_N_per_mm2": [5.0e3, 1.0e4, 5.0e4],
            "rotational_stiffness_N_per_rad": "equal",
        },
    },
    "A line contact on rigs that yield in translation or rotation, case by case; everything is per mm of its length.",
)
