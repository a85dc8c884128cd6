"""A ROS 2 node for vbbench."""
