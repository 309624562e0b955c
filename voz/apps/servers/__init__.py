"""What all servers of voz share: bounds of connections and rates."""
