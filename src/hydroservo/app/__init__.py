"""A local web page for a loop: change a number, and see what follows."""

from hydroservo.app.serving import Address, serve

__all__ = ["Address", "serve"]
