"""A robot in a room, as geometry alone: from a state and a velocity to the next state."""
