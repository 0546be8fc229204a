"""Control of one maneuverable unit (MU): control law, estimator, controller and its node; the driver contract.

Modules other than ``controller_node``, ``driver_sample`` and ``check_driver`` never import rclpy.
"""
