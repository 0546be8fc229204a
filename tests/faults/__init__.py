"""Faulted missions: everything that may go wrong with a mission, drawn at random, and what must hold all the same.

``python -m tests.faults --missions 500`` flies a campaign of them; ``tests/faults/test_faults.py`` a short one.
"""
