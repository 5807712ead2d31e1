"""A panel and a browser before it."""

from tests.panel.browser.chrome import browsers, served

__all__ = ["browsers", "served"]
