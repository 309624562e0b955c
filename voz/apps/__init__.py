"""What stands around the robot that obeys: it imports the core, and the core imports none of it."""
