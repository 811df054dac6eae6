"""All checks; importing this package registers them."""

from . import blocks, constancy, container, fireflies, naming, order, passes, reference, time, values

__all__ = [
    "blocks",
    "constancy",
    "container",
    "fireflies",
    "naming",
    "order",
    "passes",
    "reference",
    "time",
    "values",
]
