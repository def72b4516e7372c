"""The affine system that one pairing of two surfaces poses to the contact solver."""

from dataclasses import dataclass

from geometry.arrays import Array
from solvers.compliance import PairedCompliance
from solvers.contact_layer import LayersAtNodes
from solvers.friction_law import Friction
from solvers.holder import Holder
from solvers.pairing import Pairing


@dataclass(frozen=True)
class Linearisation:
    """Affine map from tractions and holder position to gaps and slips for one pairing of k nodes.

    before: pairing of the nodes that were loaded before the increment, as the bodies stood then.
    compliance: mean displacement of the upper against the lower body at the nodes by tractions on them.
    old_displacement: (k, 3), the same for the tractions before the increment.
    lever: (k,) distance of the nodes ahead of the holder's pivot along x.  holder: what moves and resists the upper
    body; where `prescribed_height` is given, it is held there instead of loaded.  old_place_in_play: where it stood
    between the stops of its free play.
    layers: what gives way between the surfaces.  Lengths in mm, forces in N.
    """

    pairing: Pairing
    before: Pairing
    compliance: PairedCompliance
    old_displacement: Array
    friction: Friction
    paired_holder_x: float
    old_holder_x: float
    old_height: float
    drive_step: float
    old_tilt: float
    lever: Array
    holder: Holder
    pressed_height: float
    prescribed_height: float | None
    old_place_in_play: float = 0.0
    layers: LayersAtNodes | None = None
