"""Folders of files that nobody here wrote, through the program: what becomes of each, and counts of that.

Invariant: whatever a file does to the program, it has one verdict, and verdicts come in the order
of the files' names.
"""

from .files import find_files
from .limited import Limits
from .probes import Programs, Verdict, verdict_on
from .table import as_json, as_text

__all__ = ["Limits", "Programs", "Verdict", "as_json", "as_text", "find_files", "verdict_on"]
