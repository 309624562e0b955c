"""What ROS 2 starts voz by; voz itself is the Python package `voz`, in a Python of its own."""
