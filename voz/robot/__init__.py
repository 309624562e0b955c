"""Who receives the motion: one small module for each kind of robot."""
