"""Physics of a tether-net capture and the in-process mission: `from tethernet_sim.fly import fly, fly_many`.

Modules outside ``tethernet_sim.ros`` never import rclpy; numba is imported by the kernels alone.
"""
