"""Errors that are no mistake of the program; a command reports them in one sentence and ends."""

from __future__ import annotations


class InputError(ValueError):
    """What was given cannot be used: what it is, what is allowed, what to do. A command ends with exit status 2."""


class FaultError(Exception):
    """What is needed is not there or fails, whatever was given: why, what to do. A command ends with exit status 1."""
