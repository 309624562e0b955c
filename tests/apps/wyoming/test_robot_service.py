"""`voz run --wyoming`, driven by the client of the Wyoming project, as Home Assistant does it."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterator
from contextlib import AsyncExitStack, ExitStack, closing, suppress
from pathlib import Path

import httpx
import pytest
from calls import in_process
from live_robot import LiveRobot, live_robot, moves, rests
from operator_page import PageRobot, opened, own_list, page_robot
from programs import PATIENCE, free_port
from spanish import spanish_robot
from wyoming.asr import Transcript
from wyoming.client import AsyncClient
from wyoming.error import Error
from wyoming.event import Event, Eventable
from wyoming.handle import Handled, NotHandled
from wyoming.info import Describe, Info
from wyoming.intent import Entity, Intent, NotRecognized, Recognize

pytestmark = pytest.mark.slow

COMMANDS = """\
hello robot
stop speech
stop
go forward
turn: turn {side} {angle: 5..180 by 5} degrees
dance

side = left | right
"""

SETTINGS = """\
[commands]
"hello robot" = "start speech"
"turn" = { rotate = 0.5, degrees = "{angle}", say = "I turn to the {side}" }
"dance" = [{ drive = 0.1, metres = 0.1, say = "one" }, { rotate = 0.5, degrees = 10, say = "two" }]
"""


class Assistant(str):
    """A client, at an address."""

    def ask(self, *asked: Eventable) -> list[Event]:
        """Send events over a connection of their own; returns an answer to each."""

        return asyncio.run(self._talk(*asked))

    def ask_at_once(self, number: int, asked: Eventable) -> list[Event]:
        """Ask over so many connections, each of which is there before the first asks."""

        async def talk() -> list[Event | None]:
            async with AsyncExitStack() as stack:
                clients = [
                    await stack.enter_async_context(AsyncClient.from_uri(self))
                    for _ in range(number)
                ]
                for client in clients:
                    await client.write_event(asked.event())
                return [await asyncio.wait_for(each.read_event(), PATIENCE) for each in clients]

        return [answer for answer in asyncio.run(talk()) if answer]

    async def _talk(self, *asked: Eventable) -> list[Event]:
        async with AsyncClient.from_uri(self) as client:
            for event in asked:
                await client.write_event(event.event())
            answers = [await asyncio.wait_for(client.read_event(), PATIENCE) for _ in asked]
            return [answer for answer in answers if answer]

    def order(self, text: str) -> Event:
        (answer,) = self.ask(Transcript(text, context={"conversation_id": "7"}, language="en"))
        return answer

    def handled(self, text: str) -> str | None:
        """What the robot answers to a command that it obeys."""
        answer = self.order(text)
        assert Handled.is_type(answer.type), answer
        assert Handled.from_event(answer).context == {"conversation_id": "7"}
        return Handled.from_event(answer).text

    def refused(self, text: str) -> str | None:
        answer = self.order(text)
        assert NotHandled.is_type(answer.type), answer
        return NotHandled.from_event(answer).text


@pytest.fixture(scope="module")
def run(
    no_sound_card: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[LiveRobot, Assistant]]:
    """A robot without a microphone, and the assistant that drives it."""
    uri = f"tcp://127.0.0.1:{free_port()}"
    given = own_list(tmp_path_factory.mktemp("robot"), COMMANDS, SETTINGS)
    with live_robot(no_sound_card, "--wyoming", uri, *given) as robot:
        yield robot, Assistant(uri)
    assert "there is no microphone" in robot.words
    assert "listening to typed commands and Wyoming clients" in robot.words


@pytest.mark.realtime
def test_a_spanish_robot_answers_in_spanish(no_sound_card: dict[str, str], tmp_path: Path) -> None:
    assistant = Assistant(f"tcp://127.0.0.1:{free_port()}")
    arguments = ["--wyoming", str(assistant), "--config", str(spanish_robot(tmp_path))]
    with live_robot(no_sound_card, *arguments) as robot:
        assert assistant.refused("Avanza.") == "no obedecido: di antes «empieza a escuchar»"
        assert assistant.handled("empieza a escuchar") == "bip bip. Te escucho"
        assert assistant.handled("¡Avanza!") == "avanza"
        robot.wait_for(moves)
        unknown = NotRecognized.from_event(assistant.order("avanzo"))
        assert unknown.text == "no es una orden; ¿querías decir «avanza»?"
    assert "no hay micrófono: solo se obedece a órdenes tecleadas" in robot.words
    assert "escucho órdenes tecleadas y clientes Wyoming; di antes" in robot.words


def test_it_tells_what_it_is(run: tuple[LiveRobot, Assistant]) -> None:
    _, assistant = run
    (answer,) = assistant.ask(Describe())
    info = Info.from_event(answer)
    for (program,) in (info.handle, info.intent):
        assert (program.name, program.installed, program.models[0].languages) == (
            "voz robot",
            True,
            ["en"],
        )
        assert "go forward" in (program.description or "")
    assert info.asr == []


def test_an_intent_has_its_slots_and_moves_nothing(run: tuple[LiveRobot, Assistant]) -> None:
    robot, assistant = run
    answers = assistant.ask(
        Recognize("Turn left 90 degrees."), Recognize("turn around", {"room": "hall"})
    )
    assert Intent.from_event(answers[0]) == Intent(
        "turn", [Entity("side", "left"), Entity("angle", 90)]
    )
    assert NotRecognized.is_type(answers[1].type)
    unknown = NotRecognized.from_event(answers[1])
    assert unknown.context == {"room": "hall"}
    assert (unknown.text or "").startswith("not a command")
    assert not any(moves(arrived.event) for arrived in robot.arrived)


def test_a_transcript_drives_and_is_answered_by_the_reply(
    run: tuple[LiveRobot, Assistant],
) -> None:
    robot, assistant = run
    assert assistant.handled("stop speech") == "stop speech"
    assert assistant.handled("Help!") == "you can say: hello robot, stop speech, stop"
    assert assistant.refused("Go forward.") == 'not obeyed: say "hello robot" first'
    assert assistant.handled("hello robot") == "bep bep. I am listening you"
    assert assistant.handled("turn right 20 degrees") == "I turn to the right"
    since = len(robot.arrived)
    assert assistant.handled("dance") == "one"
    assert assistant.handled("Go forward.") == "go forward"
    moved = robot.wait_for(moves, since)
    assert assistant.handled("stop") == "stop"
    robot.wait_for(rests, robot.arrived.index(moved))
    answer = assistant.order("go sideways")
    assert NotRecognized.is_type(answer.type)
    given = [event for event in robot.of("utterance") if event["obeyed"]]
    assert {event["source"] for event in given} == {"wyoming"}
    assert {"side": "right", "angle": 20} in [event.get("slots") for event in given]


@pytest.fixture(scope="module")
def served(no_sound_card: dict[str, str]) -> Iterator[tuple[PageRobot, Assistant]]:
    """A robot with a page, and the assistant that drives it, too."""
    assistant = Assistant(f"tcp://127.0.0.1:{free_port()}")
    with page_robot(no_sound_card, "--listening", "--wyoming", assistant) as robot:
        yield robot, assistant


def test_a_flood_of_commands_is_refused_and_a_stop_is_not(
    run: tuple[LiveRobot, Assistant],
) -> None:
    _, assistant = run
    answers = assistant.ask_at_once(40, Transcript("hello robot"))
    refused = [answer for answer in answers if NotHandled.is_type(answer.type)]
    assert {NotHandled.from_event(answer).text for answer in refused} == {"too many commands"}
    stopped = assistant.ask_at_once(40, Transcript("stop"))
    assert all(Handled.is_type(answer.type) for answer in stopped)


def test_a_flood_of_questions_is_refused_too(run: tuple[LiveRobot, Assistant]) -> None:
    """Asked what is quickly understood: any machine answers more than the ten a second allowed."""
    _, assistant = run
    answers = assistant.ask(*[Recognize("dance")] * 100)
    refused = [answer for answer in answers if NotRecognized.is_type(answer.type)]
    assert {NotRecognized.from_event(answer).text for answer in refused} == {"too many commands"}
    flood = assistant.ask(*[Describe()] * 1000)
    assert len(flood) < 1000  # it was let go
    assert Error.from_event(flood[-1]).text == "too many events"


FEW_FILES = "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (128, 128)); "


@pytest.mark.parametrize("data", [b"", b'{"type": "x'], ids=["nothing", "half"])
def test_as_many_idle_connections_as_somebody_can_hold_keep_no_stop_out(
    data: bytes, no_sound_card: dict[str, str]
) -> None:
    assistant = Assistant(f"tcp://127.0.0.1:{free_port()}")
    options = ["--listening", "--wyoming", assistant]
    with page_robot(no_sound_card, *options, before=FEW_FILES) as robot, ExitStack() as stack:
        for address in [assistant, robot.link.strip("/")] * 200:
            client = stack.enter_context(socket.socket())
            client.setblocking(False)  # the system tries again where the queue is full
            client.connect_ex(("127.0.0.1", int(address.rpartition(":")[2])))
            with suppress(OSError):
                client.sendall(data)
        robot.drives("go forward")
        assert assistant.handled("stop") == "stop"
        robot.drives("go back")
        assert httpx.post(f"{robot.link}api/stop", timeout=PATIENCE).json()["stopped"]
        assert robot.state["now"]["linear"] == 0


@pytest.mark.parametrize("garbage", [b"{}\n", b'{"type": "transcript"}\n', b"\xff\n"])
def test_garbage_ends_its_connection_and_nothing_else(
    garbage: bytes, run: tuple[LiveRobot, Assistant]
) -> None:
    _, assistant = run
    port = int(assistant.rpartition(":")[2])
    with closing(socket.create_connection(("127.0.0.1", port), PATIENCE)) as client:
        client.sendall(garbage)
        client.shutdown(socket.SHUT_WR)
        assert client.recv(1000) == b""
    assert assistant.handled("stop") == "stop"


def test_while_somebody_drives_from_the_page_an_assistant_can_only_stop(
    served: tuple[PageRobot, Assistant],
) -> None:
    robot, assistant = served
    assert assistant.handled("go forward") == "go forward"
    with opened(robot) as page:
        page.start_driving()
        assert assistant.refused("go back") == "somebody drives the robot from the operator page"
        assert assistant.handled("stop") == "stop"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--text", "-"], "--wyoming is for live runs"),
        (["--no-safety"], "leave the safety rules on"),
        (["--device", "none", "--no-sound"], "cannot listen there"),
    ],
)
def test_what_cannot_be_is_one_line(options: list[str], complaint: str) -> None:
    done = in_process("run", "--wyoming", "nonsense", *options)
    assert complaint in done.complaint
