"""`voz doctor`: checks what a robot needs in order to obey, each part by a small function."""
