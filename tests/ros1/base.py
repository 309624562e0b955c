"""A base on ROS 1: it turns as it is told, and tells its odometry 20 times a second.

Its one argument is how long it goes on without a velocity, s.
"""

import sys
import time

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

patience = float(sys.argv[1])
asked = Twist()
came = time.monotonic()


def take(velocity: Twist) -> None:
    global asked, came
    asked, came = velocity, time.monotonic()


rospy.init_node("base")
odom = rospy.Publisher("odom", Odometry, queue_size=1)
rospy.Subscriber("cmd_vel", Twist, take, queue_size=1)
while not rospy.is_shutdown():
    told = Odometry()
    if time.monotonic() - came < patience:
        told.twist.twist = asked
    odom.publish(told)
    time.sleep(0.05)
