"""Sound that goes out: what is to be heard, and the loudspeaker that gives it."""
