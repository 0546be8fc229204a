"""Data sets of flown missions, and what they are made of."""
