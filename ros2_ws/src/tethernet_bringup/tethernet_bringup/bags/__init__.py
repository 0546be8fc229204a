"""Recordings: writing, reading, what is left of a damaged one."""
