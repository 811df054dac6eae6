"""All checks; importing this package registers them."""

from . import constancy, container, fireflies, naming, passes, reference, time, values

__all__ = ["constancy", "container", "fireflies", "naming", "passes", "reference", "time", "values"]
