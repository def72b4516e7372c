"""States of a joint in closed form: a slider behind its own stiffness (Jenkins), which nothing wears.

A branch rises by the stiffness from reversal to friction and slides on under it, the other way round by Masing's rule:
micro-slip of the first order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wirewear.diagnosis.surrogate.loop_states import EVEN_POWERS, LIFT_POWERS, ODD_POWERS
from wirewear.diagnosis.surrogate.sticking import FREEDOMS
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.test.study import JointStudy


@dataclass(frozen=True, eq=False)
class JointStates(WearStates):
    """States of a joint, which does not wear: two equal rows, as interpolation needs two."""

    has_layers = False
    stiffening: ClassVar[float] = 0.0  #: 0: a joint's stiffness is stated for any load.
    sliding_freedoms: ClassVar[Mapping[str, float]] = FREEDOMS

    @classmethod
    def of_study(cls, study: JointStudy) -> JointStates:
        """The states of a joint by its stated friction, load and stiffness. A stiffness so large that friction would
        move the joint by less than 0.01 % of the amplitude counts as that limit.
        """
        load, friction, stated = study.conditions.normal_load_N, study.contact.friction, study.contact
        # Share of the displacement amplitude that a rigid joint takes under its friction.
        rigid = friction * load / (1e-4 * study.conditions.displacement_amplitude_um)
        own = stated.contact_stiffness_N_per_mm
        rows = np.arange(2.0)
        return cls(
            radius_um=1.0,
            friction=friction,
            normal_load_N=load,
            fresh_area_um2=1.0,
            volume_um3=rows,
            slip_um=np.ones(2),
            similarity=rows,
            slope=np.zeros((2, len(ODD_POWERS))),
            angle=np.zeros((2, len(EVEN_POWERS))),
            stiffness_N_per_um=np.full(2, rigid if own == "rigid" else min(1e-3 * float(own), rigid)),
            load_drop_N=np.zeros(2),
            lift_N=np.zeros((2, len(LIFT_POWERS))),
            scars=np.zeros((2, 2, 4)),
            full_slip=1.0,
        )
