"""Sound output: playing sounds, mixing them, and the loudspeaker."""
