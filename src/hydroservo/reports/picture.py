"""Pictures inside a page."""

import base64
from pathlib import Path


def address(path: Path) -> str:
    """A picture as an address that holds the picture itself.

    Args:
        path: an SVG.
    """
    return "data:image/svg+xml;base64," + base64.b64encode(path.read_bytes()).decode()
