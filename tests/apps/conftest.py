"""What the tests of pages and of other programs share."""

from __future__ import annotations

import os

import pytest


@pytest.fixture(scope="session")
def no_sound_card(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment in which there is no microphone but a browser."""
    config = tmp_path_factory.mktemp("alsa") / "alsa.conf"
    config.write_text("pcm.default { type hw card 99 }")
    return os.environ | {"ALSA_CONFIG_PATH": str(config)}
