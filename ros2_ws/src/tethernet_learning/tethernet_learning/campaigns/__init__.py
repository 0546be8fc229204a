"""Campaigns: many missions flown in process, their outcomes in one file, tables and maps of them.

``python -m tethernet_learning.campaigns --help``
"""
