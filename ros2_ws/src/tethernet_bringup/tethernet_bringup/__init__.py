"""Starts, watches, records and analyses a mission."""
