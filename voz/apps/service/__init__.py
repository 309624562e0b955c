"""voz as a service of systemd's, which starts with the computer: `voz service`."""
