"""From templates to the commands that the rest of voz asks."""
