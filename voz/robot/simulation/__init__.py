"""A robot in a room: its geometry, its way through the room, and pictures of that."""
