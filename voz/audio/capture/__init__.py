"""Sound that comes in: microphones, recordings, arrays, all as 16 kHz."""
