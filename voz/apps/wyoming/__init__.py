"""voz as the speech-to-text of Home Assistant and of satellites, by the Wyoming protocol."""
