"""Physics of a tether-net capture and the in-process mission: `from tethernet_sim.fly import fly, fly_many`.

Depends on tethernet_control only. Modules other than ``sim_node`` never import rclpy; numba is imported by the
kernels alone.
"""
