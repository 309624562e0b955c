"""The process of a program: signals, memory, threads, standard streams, exit."""
