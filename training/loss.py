"""What the student is taught: to say in noise what the teacher says without, and known phones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

import torch
from alignment import align, phones_within
from numpy.random import Generator
from torch import Tensor
from torch.nn import functional

from voz.language.phones import in_english

PHONE_FRAME = 5.0
"""So many times a moment with a phone counts as one with a blank."""

LABEL_WEIGHT = 0.3
"""Weight of the known phones where the teacher reads them, too."""

TEACHER_LOSS_LIMIT = 2.0
"""Where the teacher's loss for a known phone is larger, nats, the label counts and not it."""

MIN_LOG_PROB = -30.0

RIVALS = 4
"""Sequences of phones near to that of a clip that the student must find less likely."""

MMI_WEIGHT = 0.2
"""Weight of how likely it finds them, beside the known phones."""

MMI_TEMPERATURE = 2.0
"""Nats by which a sequence must be ahead to count as e times likelier: moments are too sure."""

CONFUSABLE = (
    "AA AE AH AO AW AY EH ER EY IH IY OW OY UH UW",
    "B D G K P T CH JH",
    "F V TH DH S Z SH ZH HH",
    "M N NG L R W Y",
)
"""Phones that are taken for one another; others go with the nearest English one."""

Labels = list[tuple[str, ...] | None]
"""The phones of each clip, where they are known."""


class Phones:
    """Adds up the symbols of the network that each phone of a language may sound like.

    Args:
        symbols: of the network.
        sounds: those of each phone.
        device: that computes.
    """

    def __init__(
        self, symbols: Sequence[str], sounds: Mapping[str, Sequence[str]], device: torch.device
    ) -> None:
        groups = [
            [phone for phone in sounds if in_english((phone,))[0] in group.split()]
            for group in CONFUSABLE
        ]
        self.confusable = {phone: group for group in groups for phone in group}
        self.numbers = {phone: number for number, phone in enumerate(sounds, start=1)}
        self._names = {number: phone for phone, number in self.numbers.items()}
        names = list(symbols)
        merged = torch.zeros(len(symbols), len(sounds) + 2)
        merged[-2:, 0] = 1
        for phone, alike in sounds.items():
            merged[[names.index(symbol) for symbol in alike], self.numbers[phone]] = 1
        merged[merged.sum(dim=1) == 0, -1] = 1  # symbols that stand for no phone
        self._merged = merged.to(device)

    def log_probabilities(self, symbols: Tensor) -> Tensor:
        """Batch x moments x (blank, phones, anything else), normalized."""
        merged = torch.log(symbols.exp() @ self._merged + 1e-12)
        return functional.log_softmax(merged, dim=-1)

    def reading(self, symbols: Tensor) -> str:
        """The most likely phones of one clip, moments x symbols, with a space between."""
        best = self.log_probabilities(symbols).argmax(dim=-1).tolist()
        return " ".join(self._names[number] for number, _ in groupby(best) if number in self._names)

    def loss(self, likely: Tensor, labels: Sequence[Sequence[str]]) -> Tensor:
        """Connectionist temporal classification of what `log_probabilities` gives, nats a clip."""
        targets = [self.numbers[phone] for label in labels for phone in label]
        return functional.ctc_loss(
            likely.transpose(0, 1),
            torch.tensor(targets, device=likely.device),
            torch.full((len(labels),), likely.shape[1]),
            torch.tensor([len(label) for label in labels]),
            reduction="none",
            zero_infinity=True,
        )

    def within(
        self, symbols: Tensor, labels: Labels, starts: Sequence[int], moments: int
    ) -> Labels:
        """Those phones of each clip that are said in a stretch of it; None if that is not clear."""
        known = [clip for clip, label in enumerate(labels) if label]
        found: Labels = [None] * len(labels)
        if not known:
            return found
        likely = self.log_probabilities(symbols[known]).cpu().numpy()
        numbers = [[self.numbers[phone] for phone in labels[clip] or ()] for clip in known]
        for clip, spans in zip(known, align(likely, numbers), strict=True):
            begin = starts[clip]
            if spans:
                found[clip] = phones_within(spans, labels[clip] or (), begin, begin + moments)
        return found


def loss_of(
    student: Tensor,
    teacher: Tensor,
    labels: Sequence[tuple[str, ...] | None],
    phones: Phones,
    rng: Generator,
    *,
    most_trust: float,
) -> tuple[Tensor, Tensor]:
    """How far the student is from what it is taught.

    Args:
        student: its log-probabilities in noise, batch x moments x symbols.
        teacher: the other network's without noise, of the same shape.
        labels: the phones of each clip where they are known.
        phones: of the network's symbols.
        rng: chooses what else the known phones are compared with.
        most_trust: how much the teacher counts where the phones are known, from 0 to 1.

    Returns:
        The divergence from the teacher and the weighted loss of the known phones, nats; the sum of
        both is what is made small.
    """
    speech = 1 - teacher[..., -2:].exp().sum(dim=-1)
    weight = 1 + (PHONE_FRAME - 1) * speech
    divergence = (teacher.exp() * (teacher - student.clamp(min=MIN_LOG_PROB))).sum(dim=-1)
    trust = torch.ones(len(labels), device=student.device)
    known = [number for number, label in enumerate(labels) if label]
    labeled = student.new_zeros(())
    if known:
        wanted = [label for label in labels if label]
        lengths = torch.tensor([len(label) for label in wanted], device=student.device)
        doubt = phones.loss(phones.log_probabilities(teacher[known]), wanted) / lengths
        trust[known] = most_trust * torch.exp(-torch.clamp(doubt - TEACHER_LOSS_LIMIT, min=0))
        likely = phones.log_probabilities(student[known])
        each = phones.loss(likely, wanted)
        rivals = rival_loss(likely, each, wanted, phones, rng)
        weights = LABEL_WEIGHT + 1 - trust[known]
        labeled = (weights * each / lengths + MMI_WEIGHT * rivals).sum() / len(labels)
    return (divergence * weight * trust[:, None]).sum() / weight.sum(), labeled


def rival_loss(
    likely: Tensor, each: Tensor, labels: Sequence[tuple[str, ...]], phones: Phones, rng: Generator
) -> Tensor:
    """How likely it is that each clip says something else that is nearly its phones, nats.

    A recognizer chooses between sentences: what is near must come out less likely (maximum mutual
    information, Bahl et al. 1986, doi:10.1109/ICASSP.1986.1169179).
    """
    near = [nearly(label, phones.confusable, rng) for label in labels for _ in range(RIVALS)]
    others = phones.loss(likely.repeat_interleave(RIVALS, dim=0), near).view(-1, RIVALS)
    scores = torch.cat([-each[:, None], -others], dim=1) / MMI_TEMPERATURE
    return -functional.log_softmax(scores, dim=1)[:, 0]


def nearly(
    label: Sequence[str], confusable: Mapping[str, Sequence[str]], rng: Generator
) -> tuple[str, ...]:
    """Phones with one or two of them changed, left out or added."""
    phones = list(label)
    while tuple(phones) == tuple(label):
        for _ in range(1 + (len(label) > 3 and rng.random() < 0.5)):
            place = int(rng.integers(len(phones)))
            like = confusable[phones[place]]
            change = rng.random()
            if change < 0.6:
                phones[place] = like[rng.integers(len(like))]
            elif change < 0.8 and len(phones) > 1:
                del phones[place]
            else:
                phones.insert(place, [*confusable][rng.integers(len(confusable))])
    return tuple(phones)
