"""A robot in a room, as geometry alone: state, velocity asked for and a time step give a state."""
