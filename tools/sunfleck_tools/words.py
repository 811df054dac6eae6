"""Text from files, for messages in a line."""

import unicodedata


def printable(text: str) -> str:
    """Text with control characters, line ends and invalid characters escaped as in Python: `\\x1b`, `\\n`,
    `\\udcff`."""
    return "".join(
        character if not unicodedata.category(character).startswith("C") else character.encode("unicode_escape").decode()
        for character in text
    )
