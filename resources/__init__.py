"""Icons, udev rules, desktop entry, YARP and ROS 2 files: what is installed beside the code."""
