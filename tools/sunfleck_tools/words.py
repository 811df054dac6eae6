"""Text that comes from files, as it may stand in a line."""

import unicodedata


def printable(text: str) -> str:
    """The text with what would move the cursor, end the line or is no character escaped as Python would:
    `\\x1b`, `\\n`, `\\udcff`."""
    return "".join(
        character if not unicodedata.category(character).startswith("C") else character.encode("unicode_escape").decode()
        for character in text
    )
