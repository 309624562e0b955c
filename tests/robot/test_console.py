from __future__ import annotations

import io

from msgspec.structs import replace

from voz.events import (
    Attention,
    CallFunction,
    Notice,
    Partial,
    Play,
    ProgramEnded,
    Publish,
    Reply,
    SelectedObject,
    StartProgram,
    Twist,
    Utterance,
)
from voz.robot.console import ConsoleRobot


def printed(*events: object, verbose: bool = False, language: str = "en") -> list[str]:
    stream = io.StringIO()
    robot = ConsoleRobot(stream, verbose, language)
    for event in events:
        robot.receive(event)
    return [line.split(" s  ")[1].strip() for line in stream.getvalue().splitlines()]


def test_only_a_velocity_that_changes_is_printed() -> None:
    lines = printed(
        Twist(0.0, 0.0, 0.0), Twist(0.1, 0.1, -0.1), Twist(0.2, 0.1, -0.1), Twist(0.3, 0.0, 0.0)
    )
    assert lines == [
        "robot drives forward at 0.10 m/s and turns right at 0.10 rad/s",
        "robot stands still",
    ]


def test_everything_else_is_told_in_words() -> None:
    lines = printed(
        Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", obeyed=True),
        Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav"),  # nothing here could obey
        Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", ignored="not_listening"),
        Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", ignored="robot_speaking"),
        Utterance(1.0, "go back", 0.1, False, 0.1, 0.9, "a.wav", "part_of_a_command"),
        Utterance(1.0, "go", 0.1, False, 0.1, 0.9, "a.wav", "unsure_between", ("stop", "go")),
        Utterance(1.0, "", 0.0, False, 0.1, 0.9, "a.wav", "too_short"),
        SelectedObject(1.1, 2),
        Reply(1.2, "bep bep"),
        Notice(1.3, "no loudspeaker"),
        Notice(1.4, "listening again", good=True),
    )
    assert lines == [
        'heard    "go back" (0.93)',
        'heard    "go back" (0.93)',
        'ignored  "go back" (0.93), not obeyed: say "start speech" first',
        'ignored  "go back" (0.93), not obeyed: the robot was speaking',
        'ignored  "go back" (0.10), part of a command',
        'ignored  "go" (0.10), unsure between "stop" and "go"',
        "ignored  something, too short",
        "robot selects object 2",
        'robot says "bep bep"',
        "warning: no loudspeaker",
        "listening again",
    ]


EVERYTHING = (
    Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", obeyed=True),
    Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", ignored="not_listening"),
    Utterance(1.0, "go back", 0.934, True, 0.1, 0.9, "a.wav", ignored="too_late"),
    Utterance(1.0, "go", 0.1, False, 0.1, 0.9, "a.wav", "unsure_between", ("stop", "go")),
    Utterance(1.0, "", 0.0, False, 0.1, 0.9, "a.wav", "part_of_a_command"),
    Partial(1.0, "stop", 0.5),
    Twist(1.1, -0.1, 0.1),
    Twist(1.1, 0.0, 0.0),
    SelectedObject(1.1, 2),
    Attention(1.1, False),
    Attention(1.2, True, ("si", "no")),
    Reply(1.2, "bip"),
    Publish(1.3, "luz", True),
    Play(1.3, "bell"),
    StartProgram(1.3, ("date",)),
    CallFunction(1.3, "robot:blink"),
    ProgramEnded(1.3, "date"),
    ProgramEnded(1.3, "date", "exit code 3"),
    Notice(1.3, "control loop stalled for 0.6 s: the robot stops"),
    Notice(1.4, "listening again; the robot waits for a command", good=True),
)


def test_it_speaks_the_language_of_the_robot() -> None:
    assert printed(*EVERYTHING, language="es") == [
        'oído     "go back" (0.93)',
        'ignorado "go back" (0.93), no obedecido: di antes «start speech»',
        'ignorado "go back" (0.93), no obedecido: llegó demasiado tarde',
        'ignorado "go" (0.10), duda entre «stop» y «go»',
        "ignorado algo, solo parte de una orden",
        'quizás   "stop" (0.50)',
        "el robot retrocede a 0.10 m/s y gira a la izquierda a 0.10 rad/s",
        "el robot está parado",
        "el robot elige el objeto 2",
        "el robot está dormido",
        "el robot espera si o no",
        "el robot dice «bip»",
        "luz: True",
        "el robot reproduce bell",
        "ejecuta date",
        "llama a robot:blink",
        "date ha terminado",
        "date ha terminado: código de salida 3",
        "aviso: el control se ha detenido 0.6 s: el robot se para",
        "vuelvo a escuchar; el robot espera una orden",
    ]
    french = printed(*EVERYTHING, language="fr")
    assert french[6] == "le robot recule à 0.10 m/s et tourne à gauche à 0.10 rad/s"
    assert not {*printed(*EVERYTHING), "luz: True"} & {*french} - {"luz: True"}


def test_if_asked_it_tells_the_score_and_what_fits_next_best() -> None:
    refused = Utterance(1.0, "go back", 0.1, False, 0.1, 0.9, "a.wav", "not_a_command")
    line = 'ignored  "go back" (0.10), not a command'
    for score, next_best, detail in (
        (-3.14, "stop", ' [score -3.1, next best "stop"]'),
        (2.0, None, " [score 2.0]"),  # the only command there is
        (None, "stop", ' [next best "stop"]'),  # without the network
        (None, None, ""),
    ):
        heard = replace(refused, score=score, next_best=next_best)
        assert printed(heard) == [line]
        assert printed(heard, verbose=True) == [line + detail]


def test_who_has_no_name_is_not_said_to_be_awake_after_a_question() -> None:
    asked, over = Attention(1.0, True, ("yes", "no")), Attention(2.0, True)
    asleep, awake = Attention(3.0, False), Attention(4.0, True)
    assert printed(asked, over) == ["robot waits for yes or no"]
    told = ["robot is asleep", "robot is awake", "robot waits for yes or no", "robot is asleep"]
    assert printed(asleep, awake, asked, over, asleep) == told
