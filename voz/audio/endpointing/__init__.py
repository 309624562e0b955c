"""Finds speech in a stream: which stretches are louder than the room, and are voices."""
