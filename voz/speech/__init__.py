"""The robot's replies: rendered by festival or espeak-ng, and played beside the control loop."""
