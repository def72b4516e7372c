"""Pictures of results, drawn off screen: no window, no X server, no global plotting state.

`show` draws all of them. Each other drawing function takes results and returns one matplotlib figure, which `save`
writes. Names are imported only when first used, so that pages can share colours and curves without loading the rest.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from wirewear.pictures.gallery import (
        amplitude_evolution,
        drawings,
        evolution_panels,
        loops_by_cycle,
        loops_by_run,
        show,
    )
    from wirewear.pictures.mesh import body_meshes, surface_fields
    from wirewear.pictures.scar_maps import contact_maps, scar_sections, scar_series, scars_from_above
    from wirewear.pictures.scar_surfaces import scars_in_3d
    from wirewear.pictures.style import require_picture_name, save

__all__ = [
    "amplitude_evolution", "body_meshes", "contact_maps", "drawings", "evolution_panels", "loops_by_cycle",
    "loops_by_run", "require_picture_name", "save", "scar_sections", "scar_series", "scars_from_above", "scars_in_3d",
    "show", "surface_fields",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
