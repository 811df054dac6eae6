"""USD stages out of what the renderer reads, and the way back."""

from .export import Exported, ExportOptions, export_usd
from .reading.convert import Imported, import_usd

__all__ = ["ExportOptions", "Exported", "Imported", "export_usd", "import_usd"]
