"""What `import voz` shows: a recognizer, its microphone, a controller."""
