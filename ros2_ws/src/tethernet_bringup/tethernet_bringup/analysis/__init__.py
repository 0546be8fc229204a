"""Looks at a recorded mission: a table of what happened, and pictures. Needs a bag, nothing of the simulator."""
