"""ROS 2 by its own rclpy: a grabber as topics, services and parameters, and the way back."""
