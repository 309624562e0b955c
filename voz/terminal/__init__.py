"""The terminal: display and keyboard."""
