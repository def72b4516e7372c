"""The inputs of the fast model: the test as it is assumed to be, the effects at work in it, and its numerical freedoms.

A seam is a place in the chain from drive to sensors at which an effect acts (`wirewear.effects`). The numerical
freedoms are factors and shifts by which the fast model and full solvers may differ on one test.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np

from geometry.arrays import Array
from solvers import LoadCycle
from wirewear.base import kinds
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.effects import COLUMNS, Age, Ageing, Chain, ContactLaw, Seam, Stated, applied
from wirewear.effects.effect import LineChain
from wirewear.test import AnyStudy
from wirewear.test.conditions import held_by
from wirewear.test.programme import Schedule, worked_course
from wirewear.test.tables import compliance

#: Friction force and amplitude of the article's test of wires, for which effects state what one expects of them.
_KNOWN = constants("surrogate.inputs")
_WIRES_N, _WIRES_um, _WIRES_CYCLES = _KNOWN.each("wires_force", "wires_amplitude", "wires_cycles")

STEADY = LoadCycle()

#: Energy wear coefficients: 1 mm³/J in µm³/mJ.
UM3_PER_MJ = 1e6

#: Numbers of a setup that its chain does not hold.
NUMBERS = (
    *("amplitude_um", "load_N", "friction", "load_factor", "normal_spring_N_per_um", "slope_factor", "tip_factor"),
    *("tip_trend", "stretch", "stick_factor", "stick_trend", "micro_slip", "angle_rise", "held_share"),
    *("displacement_offset_um", "force_offset_N", "print_um"),
)


class AtWork(Protocol):
    """A change of the test as fast models represent it: an effect, or a quantity that may change freely over the
    cycles.
    """

    @property
    def seam(self) -> Seam | None:
        """The seam at which the change acts; None if it acts on the chain of the fast model itself."""
        ...

    @property
    def ages(self) -> Ageing:
        """The quantity by which the change's strength goes: cycles, or energy and worn volume."""
        ...

    def changed(self, described: Any, age: Age) -> Any:
        """A changed copy of `described`, the description at the change's seam, at this age of the test."""
        ...

    def predicted(self, chain: Chain) -> Chain:
        """A copy of the chain of the fast model with the change applied."""
        ...


@dataclass(frozen=True)
class SurrogateInputs:
    """One set of circumstances under which the fast model computes loops: the test as it is assumed to be, and what
    changes it.

    A sensor drive holds `amplitude_um` on the reading, a stroke drive as true displacement, unless `held` names another
    quantity. The fields from `slope_factor` on are numerical freedoms, at their neutral values by default.
    """

    amplitude_um: float  #: Displacement amplitude; if the drive holds something else, the one it begins with.
    load_N: float  #: Normal load before any wear.
    cycles: float  #: Number of cycles of the test.
    frequency_Hz: float
    drive: Literal["sensor", "stroke"]  #: Where the amplitude is held: on a reading, or the true stroke.
    friction: float
    wear_um3_per_mJ: float  #: Worn volume of both bodies per friction energy.
    #: Quantity that the drive holds in place of the amplitude: "slip", "motion", "energy" or "tangential"; "" for none.
    held: str = ""
    held_share: float = 1.0  #: The value that is held (µm, mJ or N) over amplitude_um.
    largest_um: float = np.inf  #: Amplitude that the drive may take at most to hold it.
    compliance_um_per_N: float = 0.0  #: Compliance of the holder along the motion, with rotation about a pivot.
    normal_spring_N_per_um: float = 0.0  #: Stiffness of the spring that presses the bodies.
    crossing_error_rad: float = 0.0  #: Angle whose tangent shears scars; of wires, their axes' deviation from 90°.
    print_um: float = 0.0  #: Approach that bodies keep which yield as stated, see `reference.kept_approach`.
    effects: tuple[AtWork, ...] = ()  #: Effects and free changes at work, applied in this order.
    length_mm: float = 0.0  #: Length of a line contact; zero for contacts at a point.
    contact_kind: str = kinds.CROSSED_WIRES
    motion: FastMotion = SINE  #: Displacement of the drive over time.
    load_cycle: LoadCycle = STEADY  #: Normal load over load_N within a cycle.
    #: Of a test by blocks: pairs of cycles done and of cycles under these conditions that wear as much; else empty.
    worked: tuple[tuple[float, float], ...] = ()
    friction_factor: float = 1.0  #: Factor of one specimen, as the next two.
    wear_factor: float = 1.0
    load_factor: float = 1.0
    added_compliance_um_per_N: float = 0.0  #: Beside the rig's own, as solvers hold the bodies differently.
    displacement_offset_um: float = 0.0  #: Zero error of the displacement channel.
    force_offset_N: float = 0.0  #: Zero error of the force channel.
    slope_factor: float = 1.0  #: Factor on the slopes of the worn surface.
    tip_factor: float = 0.0  #: Added to that factor towards the stroke's ends, at a similarity of one.
    tip_trend: float = 0.0  #: Change of tip_factor per decade of similarity.
    stretch: float = 1.0  #: Factor on the scar's length.
    stick_factor: float = 1.0  #: Factor on the contact's stiffness.
    stick_trend: float = 0.0  #: Change of its logarithm per decade of similarity.
    micro_slip: float = 0.0  #: Logarithm of a factor on the order of micro-slip, see `sticking`.
    angle_rise: float = 1.0  #: Factor on the change of friction by the scar along the stroke.

    @classmethod
    def of(
        cls, study: AnyStudy, drive: Literal["sensor", "stroke"], wear_mm3_per_J: float, length_mm: float = 0.0
    ) -> SurrogateInputs:
        """The inputs that a study states, without effects; `length_mm` is that of a line contact, 0 for contacts at a
        point. drive: whether the amplitude is held on a reading ("sensor") or as true displacement ("stroke").
        wear_mm3_per_J: worn volume of both bodies per friction energy.
        """
        conditions, friction, holder = study.conditions, study.contact.friction, study.holder
        tangential, rotational = holder.tangential_stiffness_N_per_mm, holder.rotational_stiffness_N_mm_per_rad
        turned = (holder.pivot_height_mm or 0.0) ** 2 * compliance(rotational)
        carried = 1e3 * (compliance(tangential) + turned)

        def force_N(own: Any) -> float:
            return float(own.contact.friction * own.conditions.normal_load_N)

        return cls(
            **_driven(conditions, force_N(study), carried, drive),
            load_N=conditions.normal_load_N,
            cycles=float(conditions.cycles),
            frequency_Hz=conditions.frequency_Hz,
            friction=friction,
            wear_um3_per_mJ=wear_mm3_per_J * UM3_PER_MJ,
            compliance_um_per_N=carried,
            normal_spring_N_per_um=1e-3 * holder.normal_spring_stiffness_N_per_mm,
            length_mm=length_mm,
            contact_kind=study.contact_kind,
            load_cycle=conditions.load_cycle or STEADY,
            worked=_worked(study, force_N, carried),
        )

    def wearing_cycles(self, cycles: Array) -> Array:
        """Numbers of cycles (n,) under these conditions alone that wear as much as the test's first `cycles` (n,);
        equal to `cycles` unless the test has blocks.
        """
        return np.interp(cycles, *np.array(self.worked).T) if self.worked else cycles

    def with_effect(self, effect: AtWork) -> SurrogateInputs:
        """A copy with one more effect, applied after the others."""
        return replace(self, effects=(*self.effects, effect))

    @property
    def follows_wear(self) -> bool:
        """True if an effect depends on the dissipated energy or the worn volume."""
        return any(effect.ages is Ageing.BY_WEAR for effect in self.effects)

    @property
    def in_time(self) -> bool:
        """True if a cycle has to be followed in time: its load varies, or an effect gives the holder a mass."""
        if not self.load_cycle.steady:
            return True
        at_holder = any(effect.seam in (Seam.HOLDER, None) for effect in self.effects)
        return at_holder and bool(self.chain(1.0, 1.0, *np.ones((3, 1))).mass_kg.any())

    @property
    def stated(self) -> Stated:
        """Stated values of the test by their keys in a study, from which parameters of effects may be scaled."""
        return {
            "conditions.displacement_amplitude_um": self.amplitude_um,
            "conditions.normal_load_N": self.load_N,
            "conditions.cycles": self.cycles,
            "conditions.frequency_Hz": self.frequency_Hz,
            "contact.friction": self.friction,
        }

    @property
    def scales(self) -> Mapping[str, float]:
        """Factors by unit on sizes of parameters that effects state for the wires of a reference article.

        Stiffnesses grow with the friction force over the amplitude, compliances fall with it, and cycles go with the
        length of the test.
        """
        forces = self.friction * self.load_N / _WIRES_N
        stiffer = forces * _WIRES_um / self.amplitude_um
        return {
            "N_per_mm": stiffer,
            "N_mm_per_rad": stiffer,
            "um_per_N": 1.0 / stiffer,
            "um_per_N2": 1.0 / (stiffer * forces),
            "cycles": self.cycles / _WIRES_CYCLES,
            "per_100k_cycles": _WIRES_CYCLES / self.cycles,
        }

    @property
    def plateau_force_N(self) -> float:
        """Friction force in N under the stated load at the end of the test, with the effects on the contact applied."""
        end = Age(self.cycles, 4e-6 * self.friction * self.load_N * self.amplitude_um * self.cycles)
        return applied(self.effects, Seam.CONTACT, ContactLaw(self.friction), end).friction * self.load_N

    def chain(self, radius_um: float, fresh_area_um2: float, cycles: Array, energy_J: Array, worn_um3: Array) -> Chain:
        """The test as a chain from drive to sensors at n moments, with all effects and the factors of the specimen
        applied.

        radius_um: of the sphere (or cylinder) that has the bodies' gap to a flat. fresh_area_um2: of the contact before
        any wear. cycles, energy_J, worn_um3: (n,) cycles done, friction energy and worn volume of both bodies. Raises
        UnforeseenError if an effect changes something that fast models do not know.
        """
        stated = {
            "amplitude_um": np.nan if self.held else self.amplitude_um,
            "load_N": self.load_N,
            "friction": self.friction,
            "wear_um3_per_mJ": self.wear_um3_per_mJ,
            "compliance_um_per_N": self.compliance_um_per_N,
            "crossing_error_rad": self.crossing_error_rad,
            "print_um": self.print_um,
            "starved_factor": 1.0,
            "gain": 1.0,
        }
        rows = np.repeat([[stated.get(name, 0.0)] for name in COLUMNS], cycles.size, axis=1)
        columns = dict(zip(COLUMNS, rows, strict=True))
        columns.update(cycles=cycles, energy_J=energy_J, worn_um3=worn_um3)
        made: type[Chain] = LineChain if self.length_mm else Chain
        chain = made(
            radius_um, fresh_area_um2, **columns, length_um=1e3 * self.length_mm, frequency_Hz=self.frequency_Hz
        )
        for effect in self.effects:
            chain = effect.predicted(chain)
        return replace(
            chain,
            friction=self.friction_factor * chain.friction,
            wear_um3_per_mJ=self.wear_factor * chain.wear_um3_per_mJ,
            load_N=self.load_factor * chain.load_N,
            compliance_um_per_N=chain.compliance_um_per_N + self.added_compliance_um_per_N,
        )


def _driven(conditions: Any, friction_N: float, compliance_um_per_N: float, drive: str) -> dict[str, Any]:
    """The amplitude that a study's drive begins with, and what it holds."""
    largest, held = conditions.displacement_amplitude_um, held_by(conditions)
    if held is None:
        return {"amplitude_um": largest, "drive": drive}
    first = held.first_um(friction_N, compliance_um_per_N * friction_N, largest)
    if held.figure == "reading":
        return {"amplitude_um": first, "drive": "sensor"}
    asked = {"held": held.figure, "held_share": held.value / first, "largest_um": largest}
    return {"amplitude_um": first, "drive": "stroke", **asked}


def _worked(
    study: AnyStudy, friction_N: Callable[[Any], float], compliance_um_per_N: float
) -> tuple[tuple[float, float], ...]:
    """Cycles of a test by blocks, each with the number of cycles under the study's own conditions that wear as much.

    friction_N: gives a study's friction force, by which the rig yields; the contact slips by the rest of the stroke.
    """
    schedule: Schedule[Any] = study.schedule
    if not schedule.blocks:
        return ()

    def worn(other: Any) -> float:
        force, largest = friction_N(other), other.conditions.displacement_amplitude_um
        stroke = _driven(other.conditions, force, compliance_um_per_N, "")["amplitude_um"]
        return float(other.worn_per_cycle * max(stroke - compliance_um_per_N * force, 0.0) / largest)

    own = worn(study)
    return worked_course(schedule.stretches, lambda other: worn(other.study) / own if own else 1.0)
