"""What a set-up can fail with."""


class SetupError(Exception):
    """The environment cannot be made: what is wrong and what to do about it, in words for the user."""
