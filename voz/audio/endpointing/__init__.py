"""Which stretches of a stream stand out of the room, and whether they are speech."""
