"""What of a stage is read, and how strictly. Invariant: whatever is not said is the stage's own word."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ImportOptions:
    """How a stage is read.

    `frames` are the first and the last; None for those of the stage. `purposes` are those shown beside
    `default`: of `render`, `proxy` and `guide`. `variants` are (path of a prim, set, choice). `masks` are
    paths: nothing but what is below them, above them, or needed by them is read. `strict` refuses a stage of
    which anything would be lost.
    """

    frames: tuple[int, int] | None = None
    purposes: tuple[str, ...] = ("render",)
    variants: tuple[tuple[str, str, str], ...] = ()
    masks: tuple[str, ...] = ()
    strict: bool = False
