"""The robots that receive the motion, a small module for each kind."""
