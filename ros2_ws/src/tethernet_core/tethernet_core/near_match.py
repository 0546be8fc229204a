"""A hint at the word that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable


def near_match(word: object, names: Iterable[str]) -> str:
    """``" (did you mean mesh_m?)"`` where one of the names is near to a word, else nothing."""
    import difflib  # only errors need it

    close = difflib.get_close_matches(str(word)[:200], list(names), n=1)
    return f" (did you mean {close[0]}?)" if close else ""
