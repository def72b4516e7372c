"""What a fit asks of a kind of contact: crossed wires and line contacts answer, all else is the same."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.fitting.values import FittedParameter
    from wirewear.planar.tables import PlanarStudy
    from wirewear.records import AnyRecord
    from wirewear.records.values import MeasuredLoop
    from wirewear.results import RunResult
    from wirewear.study import Study

#: Wear coefficient of both bodies with which wear states are made where the record does not tell it: steel on steel's.
ANY_WEAR_mm3_per_J = 3e-5

#: Worn volumes in mm³ by body and repeat, and fitted wear: parameters, and what is missing or assumed.
Volumes = Mapping[str, Mapping[int, float]]
Worn = tuple[dict[str, "FittedParameter"], list[str]]


class FitSubject(Protocol):
    """A record's test as a fit sees it.

    Attributes:
        record: what is fitted.
        rigid_N_per_mm: a rig as stiff as this takes nothing.
        where_volumes: how a laboratory gets the worn volumes into its record, for a sentence.
    """

    @property
    def record(self) -> AnyRecord:
        """What is fitted."""

    @property
    def rigid_N_per_mm(self) -> float:
        """A rig as stiff as this takes nothing."""

    @property
    def where_volumes(self) -> str:
        """How a laboratory gets the worn volumes into its record, for a sentence."""

    def worn(self, volumes: Volumes, energies_J: Mapping[int, float]) -> Worn:
        """Wear from volumes and friction energies by repeat."""

    def parted(self, total: FittedParameter) -> Worn:
        """A given wear coefficient of both bodies together, as parameters."""

    def total_of(self, parameters: Mapping[str, FittedParameter]) -> float | None:
        """Wear coefficient of both bodies together by fitted parameters; None where none was fitted."""

    def stated_wear(self) -> str | None:
        """What the record states of wear, for a sentence; None where it states nothing."""

    def contact_stiffness_N_per_um(self, friction: float) -> float:
        """Stiffness of the unworn contact and its bodies on a rigid rig."""

    def rig_compliance(self, measured_N_per_um: float, contact_N_per_um: float) -> float:
        """Compliance of the rig in µm/N behind a measured stiffness; 0 where the contact takes all of it."""

    def study(self, stated: Mapping[str, Any], effects: list[dict[str, Any]], cycles: list[int]) -> Study | PlanarStudy:
        """The record's test with these keys of `[stated]` in place of its own, and further effects; it logs cycles."""

    def states(self, study: Any, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Wear states of a finite element run of a study, and what that run says against them."""

    def run(
        self, study: Any, output: Path, fidelity: str, observer_of: ObserverOf
    ) -> tuple[RunResult, dict[int, MeasuredLoop]]:
        """A run of a study into a folder, and its loops by cycle as its sensors read them, of the whole contact."""

    def setup(self, study: Any) -> Setup:
        """The circumstances that a study states, for the fast model."""
