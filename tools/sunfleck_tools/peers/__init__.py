"""Other renderers on the same scene, all bounces off: direct light and single scattering, which is what
sunfleck computes."""

from .measure import RENDERERS, Point, measure, write_table

__all__ = ["RENDERERS", "Point", "measure", "write_table"]
