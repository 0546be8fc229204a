"""Text from outside, made fit to be seen: names, reasons and verdicts that other processes or files have written."""

from __future__ import annotations

SHORT, LONG = 80, 500
"""Usual limits: of a name, of a sentence [characters]."""


def shown(text: object, limit: int = LONG) -> str:
    """A text as it may be printed, logged or written to a file of results.

    What does not print (line ends, terminal escapes, direction marks, lone surrogates) is written as its escape, and
    what is too long is cut: nobody else's words move the cursor, forge a line, or fill a disk.

    Args:
        text: anything; its ``str`` is taken.
        limit: the most characters of the result; at least 1.
    """
    raw = str(text)
    cut = len(raw) > limit
    # A character may become ten; what is thrown away need not be looked at.
    words = "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii") for letter in raw[:limit]
    )
    return words[: limit - 1] + "…" if cut or len(words) > limit else words
