"""The phoneme network in PyTorch; `voz/recognition/network/` computes the same in numpy."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn import functional

from voz.recognition.network.phoneme_network import (
    BLOCKS,
    DEPTHWISE,
    HEADS,
    HOP,
    QUIETEST,
    TINY,
    WINDOW,
    Floats32,
    spectrum_kernels,
)

FIXED = "bands"
"""The one tensor that is not learned: the filters of the spectrum's bands."""


class Network(nn.Module):
    """Four Conformer blocks (Gulati et al. 2020, arXiv:2005.08100) without relative positions.

    Its parameters have the names of the file of weights, with `/` where that has `.`.
    """

    def __init__(self, weights: Mapping[str, Floats32]) -> None:
        super().__init__()
        for name, tensor in weights.items():
            if name != FIXED:
                self.register_parameter(name.replace(".", "/"), nn.Parameter(torch.tensor(tensor)))
        self.register_buffer(FIXED, torch.tensor(weights[FIXED]))
        for part, kernel in zip(("real", "imaginary"), spectrum_kernels(), strict=True):
            self.register_buffer(part, torch.tensor(kernel), persistent=False)

    def forward(self, samples: Tensor) -> Tensor:
        """Log-probabilities of the symbols.

        Args:
            samples: batch x samples, from -1 to 1, 16 kHz, all of one length.

        Returns:
            Batch x moments of 20 ms x symbols, natural logarithms.
        """
        x = functional.gelu(self._linear("first", _neighbors(self._spectra(samples))))
        for number in range(BLOCKS):
            x = self._block(f"blocks/{number}", x)
        return functional.log_softmax(self._linear("last", x), dim=-1)

    def keep_below(self, block: int) -> None:
        """Let nothing learn that lies below a block: it stays as it is."""
        kept = ("first/", *(f"blocks/{number}/" for number in range(block)))
        for name, tensor in self.named_parameters():
            tensor.requires_grad_(block == 0 or not name.startswith(kept))

    def keeps_all_of(self, weights: Mapping[str, Floats32]) -> bool:
        """Whether what does not learn is what a file of weights has."""
        kept = [(name, t) for name, t in self.named_parameters() if not t.requires_grad]
        return all(
            torch.equal(t.cpu(), torch.tensor(weights[n.replace("/", ".")])) for n, t in kept
        )

    def weights(self) -> dict[str, Floats32]:
        """The tensors as the file of weights has them; if some are kept, without those."""
        named = [(name, t) for name, t in self.named_parameters() if t.requires_grad]
        if all(tensor.requires_grad for tensor in self.parameters()):
            named.append((FIXED, self.get_buffer(FIXED)))
        return {name.replace("/", "."): t.detach().cpu().numpy().copy() for name, t in named}

    @torch.no_grad()
    def _spectra(self, samples: Tensor) -> Tensor:
        half = WINDOW // 2
        padded = functional.pad(samples[:, None], (half, half), mode="reflect")[:, 0]
        windows = padded.unfold(1, WINDOW, HOP)
        real, imaginary = (self.get_buffer(part) for part in ("real", "imaginary"))
        power = (windows @ real) ** 2 + (windows @ imaginary) ** 2
        return torch.log(torch.clamp(power @ self.get_buffer(FIXED), min=QUIETEST))

    def _block(self, name: str, x: Tensor) -> Tensor:
        x = x + 0.5 * self._feed_forward(f"{name}/ffn1", x)
        x = x + self._attention(f"{name}/attn", x)
        x = x + self._convolution(f"{name}/conv", x)
        x = x + 0.5 * self._feed_forward(f"{name}/ffn2", x)
        return self._norm(f"{name}/last", x)

    def _feed_forward(self, name: str, x: Tensor) -> Tensor:
        inner = functional.silu(self._linear(f"{name}/fc1", self._norm(name, x)))
        return self._linear(f"{name}/fc2", inner)

    def _attention(self, name: str, x: Tensor) -> Tensor:
        batch, moments, _ = x.shape
        found = self._linear(f"{name}/in_proj", self._norm(name, x))
        asked, keys, values = found.view(batch, moments, 3, HEADS, -1).permute(2, 0, 3, 1, 4)
        mixed = functional.scaled_dot_product_attention(asked, keys, values)
        return self._linear(f"{name}/out_proj", mixed.transpose(1, 2).reshape(x.shape))

    def _convolution(self, name: str, x: Tensor) -> Tensor:
        gated = functional.glu(self._linear(f"{name}/pointwise1", self._norm(name, x)))
        weight, bias = self._layer(f"{name}/depthwise")
        deep = functional.conv1d(
            gated.transpose(1, 2), weight.T[:, None], bias, padding=DEPTHWISE // 2, groups=len(bias)
        )
        return self._linear(f"{name}/pointwise2", functional.silu(deep.transpose(1, 2)))

    def _norm(self, name: str, x: Tensor) -> Tensor:
        weight, bias = self._layer(f"{name}/norm")
        return functional.layer_norm(x, weight.shape, weight, bias, TINY)

    def _linear(self, name: str, x: Tensor) -> Tensor:
        weight, bias = self._layer(name)
        return x @ weight + bias

    def _layer(self, name: str) -> tuple[Tensor, Tensor]:
        return self.get_parameter(f"{name}/weight"), self.get_parameter(f"{name}/bias")


def _neighbors(bands: Tensor) -> Tensor:
    """Every other spectrum, with the ones before and after it beside it."""
    padded = functional.pad(bands, (0, 0, 1, 1))
    length = bands.shape[1]
    return torch.cat([padded[:, place : place + length : 2] for place in range(3)], dim=2)
