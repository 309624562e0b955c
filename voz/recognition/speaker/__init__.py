"""What is learnt of a voice and a microphone."""
