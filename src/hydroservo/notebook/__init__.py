"""What notebooks show of results: what was run and what came of it, above the data."""

from hydroservo.notebook.display import show_results_in

__all__ = ["show_results_in"]
