"""ROS 2 bags: the images of two cameras and what they say of the rig, read and written without ROS."""
