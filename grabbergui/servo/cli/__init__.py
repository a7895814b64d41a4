"""The commands of the robot, found through the entry points of `grabbergui.commands`."""
