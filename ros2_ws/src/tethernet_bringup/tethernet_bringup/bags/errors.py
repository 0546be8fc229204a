"""What can go wrong with a bag: one small tree, so that a caller can catch as much as it means to."""

from __future__ import annotations

import errno

from tethernet_core.errors import FaultError


class BagError(FaultError):
    """Something about a bag is wrong; the text is meant for the user."""


class NotABagError(BagError):
    """What was given is no bag, or one that holds nothing."""


class BagWriteError(BagError):
    """The bag cannot be written (any further); what is in it is kept."""


def cause(error: OSError) -> str:
    """Why the system refused, and what to do about it where that is plain."""
    text = error.strerror or str(error)
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        text += " (a mission takes some 10 MB: free as much, or give another folder)"
    return text
