"""Live control: a microphone, a keyboard and a clock in place of recordings."""
