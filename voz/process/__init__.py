"""What a program sets for its own process: signals, memory, threads, how it ends."""
