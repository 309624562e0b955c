"""The `voz` command: each subcommand reads its options and calls the library.

What takes its time to import is imported inside the subcommand that needs it, so that
`voz --help` is there at once.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from io import TextIOWrapper
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import typer

from voz.config import Config, load_config, overridden
from voz.errors import ConfigError, SpeechError, VozError

if TYPE_CHECKING:
    from voz.evaluation.engines import EngineChoice
    from voz.evaluation.knob import Position
    from voz.evaluation.results import Result
    from voz.events import Event
    from voz.language.files import LanguageFiles
    from voz.recognition.batch import Heard, Unreadable
    from voz.recognition.profiles import Profile

Item = TypeVar("Item")

STALE = 1
"""Exit code of `build-lm --check` when files are not up to date."""

WRONG_CALL = 2
"""Exit code when an option, a file or a text cannot be used."""

SOME_UNREADABLE = 3
"""Exit code when some recordings could not be read; the others are done."""

BY_SIGNAL = 128
"""Exit code when a signal ended the program, to which the signal's number is added."""

UsageError: Any = typer.BadParameter.__mro__[1]  # typer's own or click's, as its version has it

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # the plain help takes half the time
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Offline voice control for robots: speak a command, the robot moves and answers.",
)

LmOption = Annotated[
    str | None,
    typer.Option("--lm", metavar="DIR", help="Language files; else lm/ here, else voz's own."),
]
SearchOption = Annotated[
    str | None,
    typer.Option(metavar="grammar|lm", help="Whole commands only, or the trigram model."),
]
AlarmsOption = Annotated[
    float | None,
    typer.Option(
        "--false-alarms-per-hour",
        metavar="X",
        help="How many commands may be heard in an hour of talk; else 0.5.",
    ),
]
ThresholdOption = Annotated[
    float | None, typer.Option(metavar="X", help="Confidence that is needed, 0 to 1.")
]
ConfigOption = Annotated[
    Path | None, typer.Option("--config", metavar="FILE", help="Settings, a voz.toml.")
]
ProfileOption = Annotated[
    str | None, typer.Option("--profile", metavar="NAME", help="Who speaks: see `voz calibrate`.")
]
VerboseOption = Annotated[bool, typer.Option("-v", "--verbose", help="Tell what is used.")]


@app.command("build-lm")
def build_lm(
    commands: Annotated[Path, typer.Argument(metavar="[COMMANDS]", help="The command list.")] = (
        Path("lm/comandos_voz.txt")
    ),
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write; else beside the list.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; exit with 1 if files are stale.")
    ] = False,
    alike: Annotated[
        bool, typer.Option("--alike", help="Also show the commands that sound most alike.")
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png|.svg", help="Also draw how alike all commands sound."),
    ] = None,
) -> None:
    """Make the dictionary, language model and grammar from a list of commands.

    Warns of commands that sound alike.

    Example: voz build-lm lm/comandos_voz.txt
    """
    from voz.language import build, confusion

    if alike:
        print(confusion.table(build.closest_commands(commands)))
    if picture:
        build.draw_alike(commands, picture)
    folder = out or commands.parent
    if check:
        if stale := build.check(commands, folder):
            names = ", ".join(stale)
            _tell(f"{folder}: not what {commands} gives: {names}; run `voz build-lm`")
            raise typer.Exit(STALE)
        print(f"{folder}: up to date")
        return
    result = build.build(commands, folder)
    for warning in result.warnings:
        _warn(warning)
    print(f"{result.sentences} sentences, {result.words} words:")
    for path in result.paths:
        print(f"  {path}")


@app.command()
def decode(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings.")],
    as_json: Annotated[
        bool, typer.Option("--json", help="One line of JSON for each utterance.")
    ] = False,
    search: SearchOption = None,
    false_alarms: AlarmsOption = None,
    threshold: ThresholdOption = None,
    profile: ProfileOption = None,
    lm: LmOption = None,
    config: ConfigOption = None,
    verbose: VerboseOption = False,
) -> None:
    """Tell what is said in recordings of any format and rate.

    Exits with 3 when some recordings could not be read; the others are done.

    Example: voz decode audio_fixtures/long/session.wav
    """
    from voz.recognition.batch import Unreadable, decode_recordings
    from voz.recognition.profiles import load_profile
    from voz.recognition.recognizer import Recognizer

    recognition = _asked(search, false_alarms, threshold)
    settings = _settings(config, lm=lm, recognition=recognition)
    known = load_profile(profile) if profile else None
    recognizer = Recognizer(_language(settings, verbose), settings.recognition, known)
    show = _show_json if as_json else _show_row
    if not as_json:
        print(f"   start      end  sure  obeyed  {'text':32}  file")
    unreadable = 0
    for result in decode_recordings(recognizer, _with_progress(files)):
        show(result)
        unreadable += isinstance(result, Unreadable)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


@app.command("eval")
def evaluate(
    manifests: Annotated[
        list[Path], typer.Argument(metavar="MANIFEST...", help="Lists of recordings, TSV.")
    ],
    html: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write a page with tables and pictures.")
    ] = None,
    as_json: Annotated[
        str | None,
        typer.Option("--json", metavar="FILE|-", help="Write all figures and each clip's result."),
    ] = None,
    compare: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare with what --json has written before."),
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help='voz, plain-pocketsphinx, pocketsphinx-phone-loop or "command:PROGRAM ARGUMENTS".',
        ),
    ] = "voz",
    snr: Annotated[
        str | None,
        typer.Option(metavar="DB,DB...", help="Also hear each command in noise, as 20,10,5."),
    ] = None,
    noise: Annotated[
        Path | None, typer.Option(metavar="DIR|FILE", help="Recordings of noise for --snr.")
    ] = None,
    reverb: Annotated[bool, typer.Option("--reverb", help="Play all in a room.")] = False,
    jobs: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes; else one for each core.")
    ] = None,
    search: SearchOption = None,
    false_alarms: AlarmsOption = None,
    threshold: ThresholdOption = None,
    lm: LmOption = None,
    config: ConfigOption = None,
    verbose: VerboseOption = False,
) -> None:
    """Score recordings whose texts are known: right, refused, false alarms, time.

    A manifest is a table with tabs: a line with the names of its columns, path (or file), text,
    speaker (or voice), kind and perhaps condition, then a line for each recording. Its kind is
    command, long (commands with " | " between them), near-miss, talk or noise.

    Prints the main figures, or with --html or --json writes all of them. Exits with 3 when some
    recordings could not be read; the others are done.

    Example: voz eval audio_fixtures/manifest.tsv --html report.html
    """
    from voz.evaluation import report
    from voz.evaluation.engines import EngineChoice
    from voz.evaluation.manifest import read_manifests
    from voz.evaluation.noise import noise_options
    from voz.evaluation.recognise import recognise_all, tasks_for

    report.require_libraries(pictures=html is not None)
    settings = _settings(config, lm=lm, recognition=_asked(search, false_alarms, threshold))
    choice = EngineChoice(engine, _language(settings, verbose), settings.recognition)
    others = report.read_results(compare) if compare else None
    ratios, noises = noise_options(snr, noise)
    tasks = tasks_for(read_manifests(manifests), noises, ratios, reverb)
    asked = {
        "manifests": ", ".join(map(str, manifests)),
        "engine": engine,
        "search": settings.recognition.search,
        "threshold": _number(settings.recognition.threshold),
        "false alarms per hour": _number(settings.recognition.false_alarms_per_hour),
        "snr": snr or "",
        "noise": str(noise or ""),
        "reverb": "yes" if reverb else "no",
        "compare": str(compare or ""),
    }
    with ExitStack() as files:
        page = _open(html, "w", files) if html else None
        data = _open(as_json, "w", files) if as_json else None
        results = list(_with_bar(recognise_all(tasks, choice, jobs), len(tasks)))
        knob = _knob(results, choice) if engine == "voz" else []
        evaluation = report.evaluate(results, asked, others, knob)
        if page:
            page.write(report.to_html(evaluation))
        if data:
            print(report.to_json(evaluation), file=data)
    if not (page or data):
        print(report.to_text(evaluation))
    failed = [result.error for result in results if result.error is not None]
    for error in failed:
        _tell(f"error: {error}")
    if failed:
        raise typer.Exit(SOME_UNREADABLE)


@app.command("fit-confidence")
def fit_confidence(
    manifests: Annotated[
        list[Path], typer.Argument(metavar="MANIFEST...", help="Lists of recordings, TSV.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Where to write; else the package's own model."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes; else one for each core.")
    ] = None,
    lm: LmOption = None,
) -> None:
    """Make the model of the confidence anew from recordings whose texts are known.

    Prints what would be accepted, judged by models that never heard the speaker. There must be
    half an hour of talk among the recordings, to tell how often it sounds like a command.

    Example: voz fit-confidence audio_fixtures/manifest.tsv --out mine.json
    """
    from voz.config import Recognition
    from voz.evaluation import fit_confidence as fitting
    from voz.evaluation.manifest import read_manifests
    from voz.recognition.confidence import MODEL, save_model, threshold_for

    clips = read_manifests(manifests)
    found = list(_with_bar(fitting.collect(clips, lm, jobs), len(clips)))
    examples = [example for of_clip in found for example in of_clip.examples]
    talk = sum(f.seconds for c, f in zip(clips, found, strict=True) if c.kind == "talk")
    fitted_on = [fitting.description(clips, name) for name in sorted({c.set for c in clips})]
    likely = fitting.cross_validated(examples)
    model = fitting.with_alarms(
        fitting.fit(examples, fitted_on), examples, likely, hours=talk / 3600
    )
    threshold = threshold_for(model, Recognition().false_alarms_per_hour)
    print(
        f"accepted from {threshold:.3f} on, of how many; set, kind, condition, whether it is right"
    )
    counts = fitting.acceptance(examples, likely, threshold)
    for name, (share, number) in counts.items():
        print(f"{share:8.3f} {number:5}  {name}")
    save_model(model, out or MODEL)
    print(f"written: {out or MODEL}")


@app.command()
def run(
    wav: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Recordings; may be repeated.")
    ] = None,
    more: Annotated[
        list[Path] | None, typer.Argument(metavar="[FILE...]", help="More recordings.")
    ] = None,
    text: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Typed commands, a line each.")
    ] = None,
    events: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Write all events as JSON lines.")
    ] = None,
    no_sound: Annotated[bool, typer.Option("--no-sound", help="Do not speak.")] = False,
    no_safety: Annotated[
        bool, typer.Option("--no-safety", help="The bare command rules; see the README.")
    ] = False,
    search: SearchOption = None,
    false_alarms: AlarmsOption = None,
    threshold: ThresholdOption = None,
    profile: ProfileOption = None,
    adapt: Annotated[
        bool,
        typer.Option("--adapt", help="Learn the speaker and the microphone, also for later runs."),
    ] = False,
    lm: LmOption = None,
    config: ConfigOption = None,
    verbose: VerboseOption = False,
) -> None:
    """Drive a robot by recordings or typed commands.

    In typed text, `-` alone on a line lets a cycle of 0.1 s pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --events events.jsonl
    """
    from voz import pipeline
    from voz.language.files import read_sentences
    from voz.recognition.profiles import USUAL_PROFILE, learnt_file, load_profile, save_learnt
    from voz.recognition.recognizer import Recognizer
    from voz.robot.console import ConsoleRobot

    recordings = [*(wav or []), *(more or [])]
    if bool(recordings) == bool(text):
        raise ConfigError("say what to obey: either --wav FILE... or --text FILE, see --help")
    settings = _settings(
        config,
        lm=lm,
        recognition=_asked(search, false_alarms, threshold),
        safety={"enabled": False if no_safety else None},
        speech={"enabled": False if no_sound else None},
    )
    language = _language(settings, verbose)
    unreadable: list[str] = []
    with ExitStack() as files:
        if text:
            lines, commands = _open(text, "r", files), read_sentences(language)
        else:
            known = load_profile(profile) if profile else None
            learnt = learnt_file(profile or USUAL_PROFILE, "recordings")
            if adapt:
                known = _with_learnt(known, learnt)
            recognizer = Recognizer(language, settings.recognition, known, learning=adapt)
            if adapt:
                files.callback(lambda: _warn(save_learnt(learnt, recognizer.learnt)))
        console = ConsoleRobot(sys.stderr if events == "-" else sys.stdout)
        receivers: list[Callable[[Event], None]] = [console.receive]
        if events:
            receivers.append(_event_log(_open(events, "w", files)))
        voice = settings.speech.voice if settings.speech.enabled else None
        with pipeline.running(receivers, settings.safety, voice) as robot:
            if text:
                pipeline.drive_by_text(robot, lines, commands)
            else:
                unreadable = pipeline.drive_by_recordings(robot, recordings, recognizer)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


@app.command()
def calibrate(
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="Of the profile.")] = "default",
    wav: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Recordings with a manifest.tsv; else a microphone."),
    ] = None,
    device: Annotated[
        str | None,
        typer.Option("-d", "--device", metavar="N|NAME", help="Which microphone."),
    ] = None,
    list_profiles: Annotated[
        bool, typer.Option("--list", help="Show the names of all profiles.")
    ] = False,
    delete: Annotated[
        bool, typer.Option("--delete", help="Delete the profile and its recordings.")
    ] = False,
    lm: LmOption = None,
    config: ConfigOption = None,
    verbose: VerboseOption = False,
) -> None:
    """Get to know a speaker and a microphone in two minutes.

    Shows commands to say, keeps the recordings, and finds out what helps to understand them.
    `voz run --profile NAME` and `voz decode --profile NAME` use it. Ctrl-C stops, and the same
    call goes on.

    Example: voz calibrate ana
    """
    from voz.recognition import profiles

    if list_profiles:
        print("\n".join(profiles.profile_names()))
    elif delete:
        profiles.delete_profile(name)
    else:
        from voz.cli_calibrate import make_profile

        settings = _settings(config, lm=lm)
        make_profile(name, wav, device, _language(settings, verbose), settings.recognition)


@app.command()
def say(
    text: Annotated[str | None, typer.Argument(metavar="TEXT", help="What to say.")] = None,
    voice: Annotated[str, typer.Option(metavar="NAME", help="Who says it.")] = "kal_diphone",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.wav", help="Write it instead of playing it.")
    ] = None,
    list_voices: Annotated[
        bool, typer.Option("--list-voices", help="Show the voices that are installed.")
    ] = False,
) -> None:
    """Say a text with festival.

    Example: voz say "bep bep. I am listening you" --out hello.wav
    """
    from voz.speech import festival

    if list_voices:
        print("\n".join(festival.voices()))
    elif text is None:
        raise SpeechError("there is nothing to say; give a text in quotes, see --help")
    elif out:
        festival.render(text, voice, out)
    else:
        from voz.audio.playback import play

        play(festival.cached(text, voice))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: without the program's name; None takes those of the process.

    Returns:
        The exit code, one of the constants above or 0.
    """
    # A file name may hold what the terminal cannot show; that is no reason to stop.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    _end_by_signals()
    try:
        code = app(args=arguments, prog_name="voz", standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:  # as in `voz decode ... | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BY_SIGNAL + signal.SIGPIPE
    except (VozError, OSError) as error:
        return _wrong_call(str(error))
    except UsageError as error:
        return _wrong_call(error.format_message())
    return code if isinstance(code, int) else 0


def _end_by_signals() -> None:
    """Let signals end the program by way of all `finally` blocks, which stop the robot."""

    def end(number: int, _frame: object) -> NoReturn:
        sys.exit(BY_SIGNAL + number)

    # A shell starts what it puts in the background with Ctrl-C ignored, and a robot must stop all
    # the same; whoever says `nohup` means it.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, end)


def _wrong_call(message: str) -> int:
    _tell(f"voz: {message}")
    return WRONG_CALL


def _tell(line: str) -> None:
    print(line, file=sys.stderr)


def _settings(path: Path | None, **options: Any) -> Config:
    return overridden(load_config(path) if path else Config(), options)


def _asked(
    search: str | None, false_alarms: float | None, threshold: float | None
) -> dict[str, Any]:
    return {"search": search, "false_alarms_per_hour": false_alarms, "threshold": threshold}


def _language(settings: Config, verbose: bool) -> LanguageFiles:
    """Find the language files; tell which, and whether their list has changed since."""
    from voz.language.files import find_language, stale_warning

    language = find_language(settings.lm)
    if verbose:
        _tell(f"language files: {language.folder.resolve()}")
    _warn(stale_warning(language))
    return language


def _with_learnt(known: Profile | None, path: Path) -> Profile:
    """Put what was learnt in earlier runs in place of what the profile starts from."""
    from msgspec.structs import replace

    from voz.recognition.profiles import Profile, load_learnt

    learnt, problem = load_learnt(path)
    _warn(problem)
    known = known or Profile()
    return replace(known, start=learnt) if learnt.frames else known


def _warn(problem: str | None) -> None:
    if problem:
        _tell(f"warning: {problem}")


def _open(name: str, mode: str, files: ExitStack) -> IO[str]:
    """Open a text file until `files` closes; `-` is standard input or output."""
    if name == "-":
        return sys.stdin if mode == "r" else sys.stdout
    try:
        # Typed text that is not UTF-8 is no command; it need not end the run.
        return files.enter_context(Path(name).open(mode, encoding="utf-8", errors="replace"))
    except OSError as error:
        doing = "read" if mode == "r" else "written"
        raise ConfigError(f"{name}: cannot be {doing} ({error.strerror})") from error


def _event_log(stream: IO[str]) -> Callable[[Event], None]:
    from voz.events import to_json

    return lambda event: print(to_json(event), file=stream, flush=True)


def _with_progress(files: list[Path]) -> Iterable[Path]:
    """Show a bar while the results go elsewhere; in between them it would be in the way."""
    if not sys.stderr.isatty() or sys.stdout.isatty():
        return files
    from rich.console import Console
    from rich.progress import track

    return track(files, "Decoding", console=Console(stderr=True), transient=True)


def _with_bar(results: Iterable[Item], total: int) -> Iterable[Item]:
    """Show a bar while recordings are recognised, unless nobody is there to see it."""
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    hidden = not console.is_terminal
    return track(results, "Recognising", total, console=console, transient=True, disable=hidden)


def _knob(results: Iterable[Result], choice: EngineChoice) -> list[Position]:
    from voz.evaluation.knob import positions
    from voz.language.files import read_sentences
    from voz.recognition.confidence import load_model

    return positions(results, load_model(), choice.settings, read_sentences(choice.language))


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:g}"


def _show_json(result: Heard | Unreadable) -> None:
    from voz.events import to_json

    print(to_json(result), flush=True)


def _show_row(result: Heard | Unreadable) -> None:
    from voz.events import explain
    from voz.recognition.batch import Unreadable

    if isinstance(result, Unreadable):
        print(f"{'':>26} error {result.error}", flush=True)
        return
    obeyed = "yes" if result.accepted else "no"
    why = f"({explain(result.reason, result.between)})" if result.reason else ""
    text = " ".join(part for part in (result.text, why) if part)
    print(
        f"{result.start:8.2f} {result.end:8.2f}  {result.confidence:.2f}  {obeyed:6}  "
        f"{text:32}  {result.file}",
        flush=True,
    )
