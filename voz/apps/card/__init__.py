"""What may be said, and what each command does, as a page to print."""
