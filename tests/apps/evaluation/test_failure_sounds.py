"""What can be listened to is what was heard: the stretch, in its noise."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import soundfile
from recordings import FIXTURES, GO_BACK

from voz.apps.evaluation import failure_sounds
from voz.apps.evaluation.failure_sounds import LONGEST_SOUND, sounds_of_failures
from voz.apps.evaluation.failures import OBEYED, UNREAD, Failure
from voz.apps.evaluation.recognize import Task, prepared
from voz.apps.recordings.manifest import Clip
from voz.audio import SAMPLE_RATE, Samples

SESSION = FIXTURES / "long" / "session.wav"


def task(path: Path, **noise: object) -> Task:
    return Task((Clip("set", path.name, path, "stop", "me", "command", "all"),), **noise)  # type: ignore[arg-type]


def samples(flac: bytes) -> Samples:
    found: Samples = soundfile.read(io.BytesIO(flac), dtype="int16")[0]
    return found


def test_a_clip_is_whole_and_of_a_stream_the_stretch_is_cut_out() -> None:
    whole = Failure(0, OBEYED, ())
    part, long = Failure(1, OBEYED, (), (2.0, 3.5)), Failure(1, OBEYED, (), (1.0, 999.0))
    found = sounds_of_failures([whole, part, long], [task(GO_BACK), task(SESSION)])
    session, _ = prepared(task(SESSION))
    assert np.array_equal(samples(found[whole]), soundfile.read(GO_BACK, dtype="int16")[0])
    assert np.array_equal(samples(found[part]), session[2 * SAMPLE_RATE : 7 * SAMPLE_RATE // 2])
    assert len(samples(found[long])) == LONGEST_SOUND * SAMPLE_RATE


def test_noise_is_heard_too() -> None:
    noisy = task(GO_BACK, noise=(FIXTURES / "long" / "kitchen.wav",), snr=5.0)
    failure = Failure(0, OBEYED, ())
    found = sounds_of_failures([failure], [noisy])
    assert np.array_equal(samples(found[failure]), prepared(noisy)[0])


def test_what_cannot_be_read_has_no_sound_and_of_many_the_worst_have() -> None:
    missing, good = Failure(0, UNREAD, ()), Failure(1, OBEYED, ())
    tasks = [task(Path("none.wav")), task(GO_BACK)]
    assert list(sounds_of_failures([missing, good], tasks)) == [good]
    many = [
        Failure(1, OBEYED, (), (0.0, 0.01 * number))
        for number in range(1, failure_sounds.MOST_SOUNDS + 5)
    ]
    assert list(sounds_of_failures(many, tasks)) == many[: failure_sounds.MOST_SOUNDS]
