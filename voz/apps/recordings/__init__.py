"""Recordings that are kept: manifests, folders of recordings, bags."""
