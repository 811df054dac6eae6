"""Options of reading a stage. Invariant: options that are not set leave the stage's own values."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ImportOptions:
    """Options of reading a stage.

    `frames` are the first and the last; None for those of the stage. `purposes` are those shown beside
    `default`: of `render`, `proxy` and `guide`. `variants` are (path of a prim, set, choice). `masks` are
    paths: only their descendants, ancestors and dependencies are read. `strict` refuses a stage with any
    loss.
    """

    frames: tuple[int, int] | None = None
    purposes: tuple[str, ...] = ("render",)
    variants: tuple[tuple[str, str, str], ...] = ()
    masks: tuple[str, ...] = ()
    strict: bool = False
