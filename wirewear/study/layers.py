"""Layers on a body's surface as a study states them: coatings and hard skins."""

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field, PlainValidator

from solvers import SurfaceLayer
from wirewear.base.errors import Quantity
from wirewear.study import keys

LAYERS = "coatings and hard skins on it, the outermost first, each with its thickness_um"  #: What the key holds.

Thickness = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e4))]
WearFactor = Annotated[float, PlainValidator(Quantity("1", 1e-6, 1e6))]


class LayerTable(keys.Table):
    """One layer, as elastic as the body that it lies on."""

    thickness_um: Thickness = Field(description="thickness of the layer", examples=[3.0])
    wear_factor: WearFactor = Field(1.0, description="its wear coefficient over that of the body below all layers")
    friction: keys.Friction | None = Field(
        None, description="coefficient of friction where it lies on the surface; without it that of [contact]"
    )


def layers_of(stated: Sequence[LayerTable], friction: float) -> tuple[SurfaceLayer, ...]:
    """Layers as the solvers take them, on a body of a contact of that coefficient of friction."""
    return tuple(
        SurfaceLayer(
            1e-3 * one.thickness_um, one.wear_factor, None if one.friction is None else one.friction / friction
        )
        for one in stated
    )


def unfit_layers(stated: Sequence[LayerTable], friction: float) -> str | None:
    """What is wrong with them, as the rest of a sentence, if anything."""
    if friction == 0.0 and any(one.friction is not None for one in stated):
        return "give a friction of their own, which goes with a friction above 0 in [contact] alone"
    return None
