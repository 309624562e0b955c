"""How an utterance looks in a notebook: what was heard, and both opinions."""

from __future__ import annotations

from collections.abc import Iterable

from voz.events import Utterance, explain


def utterance_html(utterance: Utterance) -> str:
    """Describe an utterance in HTML."""
    from html import escape  # 0.5 MB that no run without a notebook needs

    text = f"“{escape(utterance.text)}”" if utterance.text else "no command"
    rows = "".join(
        f"<tr><th style='text-align:left'>{who}</th>"
        f"<td style='text-align:left'>{escape(said)}</td></tr>"
        for who, said in _opinions(utterance)
    )
    return f"<div><strong>{text}</strong>, {escape(_verdict(utterance))}<table>{rows}</table></div>"


def _verdict(utterance: Utterance) -> str:
    if utterance.accepted:
        return "accepted"
    return f"not accepted: {explain(utterance.reason or 'not_a_command', utterance.between)}"


def _opinions(utterance: Utterance) -> Iterable[tuple[str, str]]:
    """Who has which opinion of an utterance, in words."""
    if not utterance.spoken:
        yield "Recognizer", "It was typed."
        return
    also = f" It might also have been “{utterance.next_best}”." if utterance.next_best else ""
    yield "Recognizer", f"It is {utterance.confidence:.0%} sure.{also}"
    if utterance.score is None:
        yield "Network", "It was not asked."
    elif utterance.score > 0:
        yield "Network", f"It hears these words, too: the evidence is {utterance.score:.1f}."
    else:
        yield "Network", f"It rather hears something else: the evidence is {utterance.score:.1f}."
