"""What can go wrong with a bag: one small tree, so that a caller can catch as much as it means to."""


class BagError(Exception):
    """Something about a bag is wrong; the text is meant for the user."""


class NotABagError(BagError):
    """What was given is no bag, or one that holds nothing."""


class BagWriteError(BagError):
    """The bag cannot be written (any further); what is in it is kept."""
