"""The command ``tethernet``: everything but flying a mission over ROS 2."""
