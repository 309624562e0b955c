"""`voz eval` as a user calls it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from calls import VOZ, Result, in_process
from msgspec.structs import replace
from programs import PATIENCE
from recordings import FIXTURES, GO_BACK, read_manifest

from voz.recognition.confidence import load_models, save_models
from voz.recognition.network.phoneme_network import DEFAULT_NETWORK, read_network, write_network

Voz = Callable[..., Result]
Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def evaluate(voz: Voz) -> Call:
    def call(*arguments: object) -> tuple[int, str, str]:
        result = voz("eval", "--lm", "lm", *arguments)
        return result.code, result.out, result.err

    return call


@pytest.fixture(scope="module")
def manifest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twenty clips of the fixtures, and one that is no recording."""
    folder = tmp_path_factory.mktemp("set")
    clips = read_manifest()
    some = [r for r in clips if r.kind == "command"][::18]
    some += [r for r in clips if r.kind == "near-miss"][::5]
    rows = [f"{r.path}\t{r.text}\t{r.voice}\t{r.kind}" for r in some]
    (folder / "bad.wav").write_text("no recording")
    path = folder / "some.tsv"
    lines = ["path\ttext\tspeaker\tkind", *rows, "bad.wav\tstop\tme\tcommand"]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.slow
def test_an_evaluation_and_a_comparison_with_it(
    evaluate: Call, manifest: Path, tmp_path: Path
) -> None:
    data, page = tmp_path / "first.json", tmp_path / "first.html"
    code, out, err = evaluate(manifest, "--json", data, "--html", page, "--jobs", 2)
    assert code == 3
    for figures in ("right and accepted", "let through", "expected calibration error"):
        assert figures in out
    written, error = err.splitlines()
    pictures = tmp_path / "first-pictures"
    assert written == f"written: {page}, {pictures}/, {data}"
    assert error.startswith("error: ")
    kept = sorted(path.name for path in pictures.iterdir())
    assert [name for name in kept if name.endswith(".svg")] == [
        "commands-and-near-misses-roc.svg",
        "confidence-and-share-right.svg",
        "missed-and-let-through-det.svg",
        "what-commands-were-taken-for.svg",
    ]
    assert [name for name in kept if name.endswith(".png")] == [
        name.replace(".svg", ".png") for name in kept if name.endswith(".svg")
    ]
    assert "bad.wav: is no recording that can be read" in error
    first = json.loads(data.read_text())
    assert len(first["results"]) == 21
    assert first["scores"]["commands"][0]["clips"] == 7
    assert first["scores"]["commands"][0]["right"]["value"] > 0.9
    assert first["settings"]["false alarms per hour"] == "the usual"
    rates = [position["false_alarms_per_hour"] for position in first["operating_points"]]
    assert rates == sorted(rates)
    assert 0.5 in rates
    text = page.read_text()
    assert "bad.wav" in text
    assert f"<td>{first['date']}</td>" in text
    assert f"<td>{first['machine']}</td>" in text
    assert datetime.fromisoformat(first["date"]).tzinfo

    plain = ("--engine", "plain-pocketsphinx", "--reverb", "--jobs", 2)
    noise = ("--snr", "30,0", "--noise", FIXTURES / "long" / "kitchen.wav")
    code, out, err = evaluate(manifest, "--compare", data, *plain, *noise)
    assert code == 3
    lines = [line.split() for line in out.splitlines()]
    rows = [line for line in lines if line and line[0] in ("some", "30", "0")]
    assert [row[0] for row in rows] == ["some", "30", "0"] * 2 + ["some"]
    assert rows[-1][1] == "7"
    assert "some, out-of-nothing, 30 dB" in out
    assert "per hour)" in out


def test_the_page_lets_a_clip_be_heard_that_went_wrong(evaluate: Call, tmp_path: Path) -> None:
    lists, page = tmp_path / "list.tsv", tmp_path / "page.html"
    rows = [f"{GO_BACK}\t{text}\tme\tcommand\n" for text in ("go back", "turn left")]
    lists.write_text("path\ttext\tspeaker\tkind\n" + "".join(rows))
    given = (lists, "--jobs", 1, "--engine", "plain-pocketsphinx", "--html", page)
    code, out, _ = evaluate(*given)
    assert code == 0
    assert "right and accepted" in out
    assert page.read_text().count("<audio") == 1
    code, out, err = evaluate(*given[:-1], "-")
    assert (code, out.count("<audio"), err) == (0, 1, "")
    assert out.startswith("<!DOCTYPE html>")


@pytest.mark.slow
def test_a_stream_is_scored_by_what_is_heard_in_its_stretches(
    evaluate: Call, tmp_path: Path
) -> None:
    session = FIXTURES / "long" / "session.wav"
    lines = [
        "path\tstart\tend\ttext\tspeaker\tkind\tcondition",
        f"{session}\t2.7\t3.7\tgo forward\tslt\tcommand\tin its place",
        f"{session}\t6.9\t8.2\tgo back\tslt\tcommand\tanother",
        f"{session}\t4.9\t6.0\tspeed it up\tslt\tnear-miss\tall",
    ]
    path = tmp_path / "stream.tsv"
    path.write_text("\n".join(lines) + "\n")
    code, out, err = evaluate(path, "--jobs", 1, "--json", "-")
    assert (code, err) == (0, "")
    found = json.loads(out)
    results = {result["condition"]: result for result in found["results"]}
    heard = {
        name: [u["text"] for u in result["heard"] if u["accepted"]]
        for name, result in results.items()
    }
    assert heard["in its place"] == ["go forward"]
    assert heard["another"] == ["turn left"]
    assert heard["all"] == ["speed up"]
    rest = heard[str(session)]
    assert rest[0] == "start speech"
    assert {"go forward", "turn left", "speed up"}.isdisjoint(rest[:1])
    (alarms,) = [s for s in found["scores"]["alarms"] if s["group"]["by"] == "all"]
    assert alarms["group"]["kind"] == "out-of-nothing"
    assert alarms["rate"]["alarms"] == len(rest)


def test_an_unreadable_stream_is_told_once(evaluate: Call, tmp_path: Path) -> None:
    path = tmp_path / "stream.tsv"
    rows = [f"none.wav\t{n}\t{n + 1}\tstop\tme\tcommand" for n in range(5)]
    path.write_text("\n".join(["path\tstart\tend\ttext\tspeaker\tkind", *rows, ""]))
    code, _, err = evaluate(path, "--jobs", 1, "--engine", "plain-pocketsphinx")
    assert code == 3
    (line,) = err.splitlines()
    assert "none.wav: there is no such file" in line


def test_an_engine_has_its_old_name_too(evaluate: Call, tmp_path: Path) -> None:
    path = tmp_path / "stream.tsv"
    path.write_text("path\ttext\tspeaker\tkind\nnone.wav\tstop\tme\tcommand\n")
    _, _, err = evaluate(path, "--jobs", 1, "--engine", "first-ear")
    assert err.splitlines()[0] == "warning: --engine first-ear is called without-network"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "MANIFEST"),
        (["none.tsv"], "none.tsv: cannot be read"),
        (["README.md"], "README.md:1: has no column"),
        (["audio_fixtures/manifest.tsv", "--snr", "10"], "--noise"),
        (["audio_fixtures/manifest.tsv", "--noise", "audio_fixtures"], "--snr"),
        (["audio_fixtures/manifest.tsv", "--snr", "x", "--noise", "lm"], "20,10,5"),
        (["audio_fixtures/manifest.tsv", "--snr", "1", "--noise", "lm"], "holds no recording"),
        (["audio_fixtures/manifest.tsv", "--compare", "README.md"], "cannot be used (JSON"),
        (["audio_fixtures/manifest.tsv", "--html", "none/x.html"], "cannot be written"),
        (["audio_fixtures/manifest.tsv", "--json", "none/x.json"], "cannot be written"),
        (["audio_fixtures/manifest.tsv", "--jobs", "0"], "--jobs"),
        (["/dev/zero"], "/dev/zero: is larger than"),
        (["audio_fixtures/manifest.tsv", "--compare", "/proc/self/mem"], "cannot be read"),
        (["audio_fixtures/manifest.tsv", "--threshold", "7"], "threshold"),
        (["audio_fixtures/manifest.tsv", "--engine", "magic", "--jobs", "1"], "magic"),
    ],
)
def test_a_wrong_call_is_one_line(arguments: list[str], said: str, evaluate: Call) -> None:
    code, out, err = evaluate(*arguments)
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert said in line


@pytest.mark.parametrize("option", ["--json", "--html"])
def test_no_result_takes_the_place_of_what_it_comes_from(
    option: str, evaluate: Call, tmp_path: Path
) -> None:
    clip, lists = tmp_path / "a.wav", tmp_path / "list.tsv"
    shutil.copy(GO_BACK, clip)
    lists.write_text("path\ttext\tspeaker\tkind\na.wav\tgo back\tme\tcommand\n")
    (tmp_path / "other").symlink_to(lists)
    before = lists.read_bytes(), clip.read_bytes()
    arguments = [lists, "--snr", "10", "--noise", GO_BACK, "--jobs", "1"]
    for result in (lists, tmp_path / "other", clip):
        code, out, err = evaluate(*arguments, option, result)
        assert (code, out) == (2, "")
        assert err.startswith(f"voz: {result}: is read ")
    assert (lists.read_bytes(), clip.read_bytes()) == before


@pytest.mark.parametrize("option", ["--json", "--html"])
def test_an_evaluation_that_is_there_is_replaced_only_if_asked(
    option: str, evaluate: Call, tmp_path: Path
) -> None:
    lists, kept = tmp_path / "list.tsv", tmp_path / "kept"
    lists.write_text(f"path\ttext\tspeaker\tkind\n{GO_BACK}\tgo back\tme\tcommand\n")
    kept.write_text("mine")
    given = (lists, "--jobs", 1, "--engine", "plain-pocketsphinx", option, kept)
    code, _, err = evaluate(*given)
    assert (code, kept.read_text()) == (2, "mine")
    assert err == (
        f"voz: {kept}: is there already; replace it by --overwrite, or name another file\n"
    )
    assert evaluate(*given, "--overwrite")[0] == 0
    assert kept.read_text() != "mine"


def test_a_model_that_is_there_is_replaced_only_if_asked(voz: Voz, tmp_path: Path) -> None:
    lists, model = tmp_path / "list.tsv", tmp_path / "mine.json"
    lists.write_text(f"path\ttext\tspeaker\tkind\n{GO_BACK}\tgo back\tme\tcommand\n")
    assert "--out" in voz("fit-confidence", lists).complaint
    model.write_text("mine")
    given = ("fit-confidence", lists, "--out", model)
    assert f"{model}: is there already" in voz(*given).complaint
    assert "more recordings of the kind talk" in voz(*given, "--overwrite").complaint


def test_no_model_takes_the_place_of_what_it_is_made_from(voz: Voz, tmp_path: Path) -> None:
    lists = tmp_path / "list.tsv"
    lists.write_text(f"path\ttext\tspeaker\tkind\n{GO_BACK}\tgo back\tme\tcommand\n")
    before = lists.read_bytes()
    result = voz("fit-confidence", lists, "--out", lists)
    assert (result.code, result.out) == (2, "")
    assert result.complaint.startswith(f"voz: {lists}: is read ")
    assert lists.read_bytes() == before


@pytest.fixture
def own_model(tmp_path: Path) -> Path:
    """The package's, which now believes nothing; voz.toml beside it names it."""
    models = load_models()
    doubting = replace(models.with_network, intercept=-99.0)
    save_models(replace(models, with_network=doubting), tmp_path / "mine.json")
    (tmp_path / "voz.toml").write_text('[recognition]\nconfidence = "mine.json"\n')
    return tmp_path / "mine.json"


def test_the_settings_name_the_model_that_judges(voz: Voz, inline: None, own_model: Path) -> None:
    decode = ("decode", "--json", GO_BACK, "--config", "voz.toml")
    (heard,) = voz(*decode, cwd=own_model.parent).json
    assert (heard["text"], heard["accepted"], heard["confidence"]) == ("go back", False, 0.0)
    (own_model.parent / "voz.toml").write_text('[recognition]\nconfidence = ""\n')
    (heard,) = voz(*decode, cwd=own_model.parent).json
    assert heard["accepted"]


def test_the_settings_name_the_network_that_hears(voz: Voz, inline: None, tmp_path: Path) -> None:
    weights, description, _ = read_network(DEFAULT_NETWORK)
    only_blanks = np.eye(len(description.symbols))[-1] * 90
    deaf = {**weights, "last.bias": weights["last.bias"] + only_blanks}
    write_network(tmp_path / "deaf.npz", deaf, description)
    settings = tmp_path / "voz.toml"
    made_by, accepted = [], []
    for number, line in enumerate(("", 'network = ""', 'network = "deaf.npz"')):
        settings.write_text(f"[recognition]\n{line}\n")
        results = tmp_path / f"{number}.jsonl"
        decode = ("decode", GO_BACK, "--config", "voz.toml", "--out", results)
        assert voz(*decode, cwd=tmp_path).code == 0
        (heard,) = map(json.loads, results.read_text().splitlines())
        made_by.append(heard["header"]["models"])
        accepted.append(heard["accepted"])
    assert accepted == [True, True, False]
    assert made_by[0] == made_by[1] != made_by[2]


def test_a_network_that_cannot_be_used_is_one_line(voz: Voz, tmp_path: Path) -> None:
    (tmp_path / "bad.npz").write_bytes(DEFAULT_NETWORK.read_bytes()[:-9])
    (tmp_path / "voz.toml").write_text('[recognition]\nnetwork = "bad.npz"\n')
    for call, *arguments in (
        (voz, "decode", GO_BACK),
        (voz, "run", "--no-sound", "--wav", GO_BACK),
        (in_process, "doctor"),  # which asks for the sound cards, once for each process
    ):
        result = call(*arguments, "--config", "voz.toml", cwd=tmp_path)
        assert "bad.npz: holds no phoneme network" in result.out + result.err


def test_no_result_takes_the_place_of_the_model(voz: Voz, own_model: Path) -> None:
    before = own_model.read_bytes()
    arguments = ("run", "--no-sound", "--config", "voz.toml", "--wav", GO_BACK)
    arguments += ("--events", "mine.json")
    complaint = voz(*arguments, cwd=own_model.parent).complaint
    assert complaint.startswith("voz: mine.json: is read ")
    assert own_model.read_bytes() == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (None, "cannot be read"),
        (lambda text: text[:200], "cannot be used"),
        (lambda text: text.replace('"phones"', '"phone"'), '"phone" is no feature of this voz'),
        (lambda text: text.replace('"alarms": 1', '"alarms": -1'), "cannot be used"),
    ],
)
def test_a_model_that_cannot_be_used_is_one_line(
    damage: Callable[[str], str] | None, said: str, voz: Voz, own_model: Path
) -> None:
    if damage:
        own_model.write_text(damage(own_model.read_text()))
    else:
        own_model.unlink()
    calls = [("decode", GO_BACK), ("eval", FIXTURES / "manifest.tsv", "--jobs", "1")]
    for call in calls:
        result = voz(*call, "--config", "voz.toml", cwd=own_model.parent)
        assert result.out == ""
        assert result.complaint.startswith("voz: mine.json: ")
        assert said in result.complaint
        assert "`voz fit-confidence`" in result.complaint


@pytest.mark.slow
def test_a_full_disk_is_one_line_and_the_figures_were_shown(
    evaluate: Call, manifest: Path, tmp_path: Path
) -> None:
    arguments = [manifest, "--engine", "plain-pocketsphinx", "--jobs", "1"]
    for option in ("--json", "--html"):
        code, out, err = evaluate(*arguments, option, "/dev/full")
        assert code == 2
        assert "right and accepted" in out
        assert err == "voz: /dev/full: cannot be written (No space left on device)\n"


@pytest.mark.slow
def test_ctrl_c_ends_all_processes_without_a_word_and_leaves_old_results(tmp_path: Path) -> None:
    data, page = tmp_path / "old.json", tmp_path / "old.html"
    data.write_text('{"results":[]}')
    page.write_text("old page")
    started = tmp_path / "started"
    (tmp_path / "slow.py").write_text(
        "import pathlib, sys, time\npathlib.Path(sys.argv[1]).touch()\ntime.sleep(0.2)\n"
    )
    engine = f"command:{sys.executable} {tmp_path / 'slow.py'} {started}"
    arguments = ["eval", FIXTURES / "manifest.tsv", "--jobs", "1", "--engine", engine]
    arguments += ["--compare", data, "--json", data, "--html", page, "--overwrite"]
    with subprocess.Popen(
        [*VOZ, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        while not started.exists():
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (130, "")
    assert "Traceback" not in err
    assert (data.read_text(), page.read_text()) == ('{"results":[]}', "old page")
