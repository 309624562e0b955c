"""What people read and hear of voz, in their language."""
