"""What the stock ``ros2`` command lacks where ROS 2 comes from wheels and nothing is sourced."""
