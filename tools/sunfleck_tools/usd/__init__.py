"""USD stages out of what the renderer reads, and the way back."""

from .export import Exported, ExportOptions, export_usd

__all__ = ["ExportOptions", "Exported", "export_usd"]
