"""The microphone's thread: half duplex, loss and return."""
