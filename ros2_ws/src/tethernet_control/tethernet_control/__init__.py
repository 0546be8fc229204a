"""Control of a tether-net's maneuverable units (MUs): layout, trajectory, control law, mission rules, driver contract.

The lowest layer. Modules outside ``tethernet_control.ros`` never import rclpy and need NumPy at most.
"""
