"""The automaton as the finite state grammar that pocketsphinx searches; pure.

It is loaded as it is: of 50,000 sentences in 15 states nothing is copied, where a grammar in JSGF
takes 470 MB. Weights make every sentence as likely as any other.
"""

from __future__ import annotations

from typing import TypeAlias

from voz.language.sentences.automaton import NO_LABEL, Automaton

FsgArc: TypeAlias = tuple[int, int, float, str] | tuple[int, int, float]
"""From one state to another with a probability, and a word unless a sentence ends."""


def to_fsg(automaton: Automaton) -> tuple[list[FsgArc], int]:
    """Write a automaton as arcs from state 0 on.

    Args:
        automaton: the sentences.

    Returns:
        The arcs, and the state in which every sentence ends.
    """
    arcs: list[FsgArc] = []
    end = len(automaton.arcs)
    for state, following in enumerate(automaton.arcs):
        count = automaton.counts[state]
        for word, to in following.items():
            arcs.append((state, to, automaton.counts[to] / count, word))
        if automaton.labels[state] != NO_LABEL:
            arcs.append((state, end, 1 / count))
    return arcs, end
