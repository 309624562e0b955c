"""How much better a command fits with a rival word in it: "cold arm" than "fold arm".

The score of a command forgives one phone that is plainly another; its rivals, in which one word is
one of the dictionary that is one phone away, do not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

from voz.language.sentences.automaton import NO_LABEL, Arcs, Automaton
from voz.recognition.network.ctc import Floats, Pronunciations, SentenceSearch

CACHED_COMMANDS = 64
"""How many commands keep the search for their rivals."""

MAX_WORDS = 3
"""Commands of more words are not compared. In long sentences people slur small words: of 40 orders
of coffee by people 35 were obeyed without rivals, and 12 with them."""

SLURRED = frozenset(
    ["a", "an", "and", "at", "for", "in", "me", "my", "of", "some", "the", "to", "with"]
)
"""Words that people slur in short sentences, too."""

OWN, RIVAL = 0, 1
"""Labels of the command itself, and of its rivals."""


class RivalWords:
    """Compares commands with their rivals."""

    def __init__(
        self,
        pronunciations: Mapping[str, Pronunciations],
        rivals: Mapping[str, Pronunciations],
        blank: int,
        reward: float,
    ) -> None:
        """Take what each word and its rivals sound like.

        Args:
            pronunciations: all of each word, as numbers of symbols.
            rivals: the pronunciations of all rivals of a word; of some words there are none.
            blank: number of the symbol between phones.
            reward: for each phone, nats.
        """
        self._pronunciations = pronunciations
        self._rivals = {
            word: [way for way in ways if way not in pronunciations[word]]
            for word, ways in rivals.items()
            if word in pronunciations  # another dictionary may have replaced that of the list
        }
        self._blank, self._reward = blank, reward
        self._search = lru_cache(CACHED_COMMANDS)(self._make_search)

    def lead(self, text: str, log_ratios: Floats, before: Floats, behind: Floats) -> float | None:
        """How much better the best rival of a command fits than the command, nats; None without.

        Args:
            text: the command.
            log_ratios: of its part of the sound, as for `best_matches`, like the next two.
            before: cost of beginning at each moment, nats.
            behind: cost of ending at each moment, nats.
        """
        search = self._search(text)
        if search is None:
            return None
        found = search.search(log_ratios, before, behind)
        return found.best_score(RIVAL) - found.best_score(OWN)

    def _make_search(self, text: str) -> SentenceSearch | None:
        words = text.split()
        if len(words) > MAX_WORDS:
            return None
        rivals = [self._audible_rivals(words, place) for place in range(len(words))]
        first = next((place for place, ways in enumerate(rivals) if ways), None)
        if first is None:
            return None
        # In the first states no word was replaced; in the rest, from `first + 1` words on, one was.
        last = len(words)
        replaced = {number: last + number - first for number in range(first + 1, last + 1)}
        arcs: Arcs = [{} for _ in range(last + len(replaced) + 1)]
        said = {word: self._pronunciations[word] for word in words}
        for number, word in enumerate(words):
            arcs[number][word] = number + 1
            if number in replaced:
                arcs[replaced[number]][word] = replaced[number + 1]
            for way in rivals[number]:
                rival = f"{word} {way}"  # any name that is no word
                said[rival] = [way]
                arcs[number][rival] = replaced[number + 1]
        labels = [NO_LABEL] * len(arcs)
        labels[last], labels[replaced[last]] = OWN, RIVAL
        return SentenceSearch(Automaton(arcs, labels), said, self._blank, self._reward)

    def _audible_rivals(self, words: Sequence[str], place: int) -> list[Sequence[int]]:
        """The rivals of a word of a sentence, but those of which a phone merges with the next word.

        Nobody hears the difference between "slowed down" and "slow down".
        """
        before = words[place - 1] if place else ""
        after = words[place + 1] if place + 1 < len(words) else ""
        ends = {way[-1] for way in self._pronunciations.get(before, ())}
        begins = {way[0] for way in self._pronunciations.get(after, ())}
        ways = () if words[place] in SLURRED else self._rivals.get(words[place], ())
        return [way for way in ways if way[0] not in ends and way[-1] not in begins]
