"""Mirrors of the world that take a placed body onto itself, found by testing them."""

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.elasticity.placement import PlacedBody

# Meshes are mirrored to the last bit, their compliance to round-off of the factorisation.
_PLACE_TOLERANCE_mm = 1e-10
_COMPLIANCE_TOLERANCE = 1e-8
_PROBES = 7


def known_images(body: PlacedBody, signs: tuple[float, float]) -> IntArray | None:
    """Where a mirror (sign_x, sign_y) of the world takes the patch's nodes, (n,); None unless it takes the body onto
    itself. Looked for once for each body.
    """
    if signs not in body.mirror_images:
        body.mirror_images[signs] = _images(body, np.array(signs))
    return body.mirror_images[signs]


def _images(body: PlacedBody, signs: Array) -> IntArray | None:
    """Where a mirror takes the patch's nodes, (n,); None unless it takes the body onto itself."""
    places, there = (np.rint(xy / _PLACE_TOLERANCE_mm) for xy in (body.node_positions, body.node_positions * signs))
    order, order_there = (np.lexsort(xy.T) for xy in (places, there))
    if not np.array_equal(places[order], there[order_there]):
        return None
    images = np.empty(len(order), dtype=np.int64)
    images[order_there] = order
    heights = body.worn(np.zeros(body.patch.shape)).heights
    if np.abs(heights - heights[images]).max() > _PLACE_TOLERANCE_mm:
        return None
    return images if _compliance_is_mirrored(body, images, np.append(signs, 1.0)) else None


def _compliance_is_mirrored(body: PlacedBody, images: IntArray, signs: Array) -> bool:
    """Whether loads on some nodes move the patch as their images move its image."""
    everywhere = np.arange(body.patch.size)
    for j in np.linspace(0, body.patch.size - 1, _PROBES).astype(int):
        own, image = (
            body.folded.between(everywhere[node : node + 1], of).reshape(3, -1, 3)
            for node, of in ((j, everywhere), (images[j], images))
        )
        own = own * signs[:, None, None] * signs
        if np.abs(own - image).max() > _COMPLIANCE_TOLERANCE * np.abs(own).max():
            return False
    return True
