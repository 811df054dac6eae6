"""USD stages, written from the renderer's inputs and read back."""

from .export import Exported, ExportOptions, export_usd
from .reading.convert import Imported, import_usd
from .reading.options import ImportOptions

__all__ = ["ExportOptions", "Exported", "ImportOptions", "Imported", "export_usd", "import_usd"]
