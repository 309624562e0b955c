"""What was heard, kept: manifests, folders of recordings, bags."""
