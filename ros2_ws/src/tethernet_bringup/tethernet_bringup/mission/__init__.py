"""One mission over ROS 2: processes, phases, outcome."""
