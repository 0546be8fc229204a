"""Benchmarks: ``make bench``, or ``python -m benchmarks.engine``. Each ends with one line of JSON."""
