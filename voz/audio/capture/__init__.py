"""Sound input: microphones, recordings and arrays, all as 16 kHz."""
