"""Comparison of frames with reference frames of the same numbers."""

from collections.abc import Iterator

from ..findings import Found, Severity, check
from ..frame import Frame
from ..summary import Rendered


def comparable(frame: Frame, reference: Frame) -> str | None:
    """Sentence if the colours of the two cannot be compared."""
    if not frame.picture or not reference.picture:
        return "one of the two has no R, G and B"
    if frame.header.data_window != reference.header.data_window:
        return (
            f"the reference's data window is {reference.header.data_window}, not {frame.header.data_window}"
        )
    if frame.header.display_window != reference.header.display_window:
        return (
            f"the reference's picture is {reference.header.display_window}, not {frame.header.display_window}"
        )
    return None


@check("reference-missing", Severity.WARNING, "a frame has no reference that it can be compared with")
def reference_missing(rendered: Rendered) -> Iterator[Found]:
    """Only with requested references."""
    for frame in rendered.decoded:
        if frame.reference_error:
            yield frame.found(frame.reference_error)


@check("reference", Severity.ERROR, "a frame is too far from its reference")
def reference(rendered: Rendered) -> Iterator[Found]:
    """Relative mean squared error, and FLIP if a limit is given."""
    options = rendered.options
    for frame in rendered.decoded:
        # Not `>`, so that NaN exceeds the limit too.
        if frame.relmse is not None and not frame.relmse <= options.max_relmse:
            error = f"relative mean square error {frame.relmse:.4g}"
            yield frame.found(f"{error}, allowed {options.max_relmse:g}")
        if frame.flip is not None and options.max_flip is not None and not frame.flip <= options.max_flip:
            yield frame.found(f"mean FLIP {frame.flip:.4g}, allowed {options.max_flip:g}")
