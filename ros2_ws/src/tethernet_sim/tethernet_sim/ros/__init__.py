"""The simulator's ROS side: messages from the world."""
