"""What studies of line contacts' rig stiffness begin with."""

from wirewear.planar.rig_stiffness.tables import KIND, RigStiffnessStudy
from wirewear.planar.template import TITANIUM
from wirewear.study.template import Template

#: A titanium cylinder on a titanium flat behind softer and softer springs.
RIG_STIFFNESS = Template(
    KIND,
    RigStiffnessStudy,
    ("material", "conditions", "cylinder"),
    {
        "material": TITANIUM,
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
