"""Crossed wires as commands ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.kinds.points import AtAPoint

if TYPE_CHECKING:
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.study.template import Template


class CrossedWires(AtAPoint):
    """Two round wires that cross; each method is described by `Kind`."""

    name: ClassVar[str] = "crossed-wires"
    names: ClassVar[tuple[str, ...]] = (name,)
    bodies: ClassVar[tuple[str, str]] = ("moving", "fixed")
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm", "crossing_angle_deg"))
    rigid_N_per_mm: ClassVar[float] = 1e6

    @property
    def template(self) -> Template:
        from wirewear.study.template import CROSSED_WIRES

        return CROSSED_WIRES

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """Wires are alike; there is no pad."""
        from wirewear.records.importing.guessing import crossed_wires, guessed_mapping

        del pad
        return guessed_mapping(files, dict(known), crossed_wires(known, own))
