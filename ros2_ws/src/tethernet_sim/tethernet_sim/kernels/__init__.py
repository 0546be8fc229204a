"""Compiled physics: numba functions on plain arrays, each working on one scenario; `step.advance` runs the batch.

Particles are numbered knots first, then MUs. Every force is found from the state at the beginning of a step, then
velocities and positions are updated in this order (semi-implicit Euler).
"""
