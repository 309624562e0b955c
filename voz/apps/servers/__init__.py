"""What all servers of voz share: bounds of connections and rates, and the way of a command."""
