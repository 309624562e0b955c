"""ROS 1: voz as nodes. rospy is Debian's, so it is imported only where a node is made."""
