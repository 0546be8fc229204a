"""Campaigns: many missions flown in process, their outcomes in one file, tables and maps of them."""
