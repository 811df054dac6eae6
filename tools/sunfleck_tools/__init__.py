"""Tools around the frames that sunfleck renders.

`validate(target, options)` says of a sequence of EXR frames whether it can be trusted; `sunfleck-tools validate` is the same
on the command line. `sunfleck_tools.usd` has what writes and reads USD stages.
"""

from .errors import SceneError, ToolError
from .options import Options
from .sequence import SequenceError
from .validation import Report, validate

__version__ = "0.1.0"
__all__ = ["Options", "Report", "SceneError", "SequenceError", "ToolError", "validate", "__version__"]
