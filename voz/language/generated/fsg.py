"""The automaton as a finite state grammar of pocketsphinx; pure.

It is loaded without copies: JSGF of 50,000 sentences takes 470 MB. Weights make all sentences
equally likely.
"""

from __future__ import annotations

from typing import TypeAlias

from voz.language.sentences.automaton import NO_LABEL, Automaton

FsgArc: TypeAlias = tuple[int, int, float, str] | tuple[int, int, float]
"""From state, to state, probability, and a word unless a sentence ends."""


def to_fsg(automaton: Automaton) -> tuple[list[FsgArc], int]:
    """Write an automaton as arcs from state 0 on, and name the final state."""
    arcs: list[FsgArc] = []
    end = len(automaton.arcs)
    for state, following in enumerate(automaton.arcs):
        count = automaton.counts[state]
        for word, to in following.items():
            arcs.append((state, to, automaton.counts[to] / count, word))
        if automaton.labels[state] != NO_LABEL:
            arcs.append((state, end, 1 / count))
    return arcs, end
