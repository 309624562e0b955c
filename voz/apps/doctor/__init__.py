"""What a robot needs in order to obey, each part looked at by a small function: `voz doctor`."""
