"""Aiming points, mission sequencing and capture assessment; planner and assessor nodes."""
