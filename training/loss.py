"""What the student is taught: to say in noise what the teacher says without, and known phones."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import torch
from torch import Tensor
from torch.nn import functional

from voz.recognition.second_ear import read_sounds

PHONE_FRAME = 5.0
"""So many times a moment with a phone counts as one with a blank."""

LABELS = 0.3
"""Weight of the known phones where the teacher reads them, too."""

DOUBT = 2.0
"""Where the teacher's loss for a known phone is larger, nats, the label counts and not it."""

LEAST = -30.0


class Phones:
    """Adds up the symbols of the network that each phone of the dictionary may sound like."""

    def __init__(self, symbols: Sequence[str], device: torch.device) -> None:
        sounds = read_sounds()
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

    def loss(self, symbols: Tensor, labels: Sequence[Sequence[str]]) -> Tensor:
        """Connectionist temporal classification, nats for each phone of each clip."""
        targets = [torch.tensor([self.numbers[phone] for phone in label]) for label in labels]
        lengths = torch.tensor([len(target) for target in targets])
        moments = torch.full((len(labels),), symbols.shape[1])
        total = functional.ctc_loss(
            self.log_probabilities(symbols).transpose(0, 1),
            torch.cat(targets),
            moments,
            lengths,
            reduction="none",
            zero_infinity=True,
        )
        return total / lengths.to(total.device)


def loss_of(
    student: Tensor, teacher: Tensor, labels: Sequence[tuple[str, ...] | None], phones: Phones
) -> tuple[Tensor, Tensor]:
    """How far the student is from what it is taught.

    Args:
        student: its log-probabilities in noise, batch x moments x symbols.
        teacher: the other network's without noise, of the same shape.
        labels: the phones of each clip where they are known.
        phones: of the network's symbols.

    Returns:
        The divergence from the teacher and the weighted loss of the known phones, nats; the sum of
        both is what is made small.
    """
    speech = 1 - teacher[..., -2:].exp().sum(dim=-1)
    weight = 1 + (PHONE_FRAME - 1) * speech
    divergence = (teacher.exp() * (teacher - student.clamp(min=LEAST))).sum(dim=-1)
    trust = torch.ones(len(labels), device=student.device)
    known = [number for number, label in enumerate(labels) if label]
    labeled = student.new_zeros(())
    if known:
        wanted = [label for label in labels if label]
        doubt = phones.loss(teacher[known], wanted)
        trust[known] = torch.exp(-torch.clamp(doubt - DOUBT, min=0))
        each = phones.loss(student[known], wanted)
        labeled = ((LABELS + 1 - trust[known]) * each).sum() / len(labels)
    return (divergence * weight * trust[:, None]).sum() / weight.sum(), labeled
