"""Colour maps."""

import base64
import io

import numpy as np
from PIL import Image

_VIRIDIS = np.array(
    [
        [68, 1, 84],
        [71, 44, 122],
        [59, 81, 139],
        [44, 113, 142],
        [33, 144, 141],
        [39, 173, 129],
        [92, 200, 99],
        [170, 220, 50],
        [253, 231, 37],
    ],
    float,
)


def viridis(share: np.ndarray) -> np.ndarray:
    """Colours [..., 3] in 0..255 (uint8) of shares in [0, 1]."""
    at = np.clip(np.nan_to_num(np.asarray(share, float)), 0, 1) * (len(_VIRIDIS) - 1)
    low = np.minimum(at.astype(int), len(_VIRIDIS) - 2)
    part = (at - low)[..., None]
    mixed = _VIRIDIS[low] * (1 - part) + _VIRIDIS[low + 1] * part
    return np.round(mixed).astype(np.uint8)


def data_url(pixels: np.ndarray) -> str:
    """A PNG of pixels [h, w, 3 or 4] (uint8) that can stand in an attribute."""
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels, np.uint8)).save(buffer, "PNG")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
