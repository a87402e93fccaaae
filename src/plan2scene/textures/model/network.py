"""The texture model: crop -> 11 numbers -> seamless texture (paper section 5.2, Figure 3).

With ``delta_hsv`` it is the paper's Synth: the network sees and makes HSV offsets from the crop's
median colour, and the embedding is the bottleneck code followed by the median RGB. Without, it is
NaiveSynth, the unmodified model of Henzler et al. (2020), whose embedding is the code alone.
Images are ``(n, 3, h, w) float32`` RGB in [0, 1].
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.textures.model import colour as colour_torch
from plan2scene.textures.model.decoder import Decoder, low_precision_is_fast
from plan2scene.textures.model.encoder import Encoder, StatisticsEncoder
from plan2scene.textures.model.noise import (
    CHANNELS,
    OCTAVES,
    plane_noise,
    position_grid,
    torus_noise,
)
from plan2scene.weights import filled, load_model_file

_TRANSFORMS = OCTAVES * 4


@dataclass(frozen=True)
class Architecture:
    """What a texture model's constructor needs.

    Attributes
    ----------
    width : int
        Channels of the residual encoder's stem (64: the paper's), or hidden units of the other.
    code_dim, style_dim : int
        Bottleneck (8) and style values (64).
    delta_hsv : bool
        Separate colour and pattern as the paper does; False is NaiveSynth.
    substances : int
        Classes of the substance head, 0 for none.
    periodic : bool
        Noise on a torus, so that textures tile; False is the reference's noise, and its HSV of
        8 bits that the residual encoder is given (it moves embeddings by some hundredths).
    encoder : str
        ``"resnet"`` (the paper's, of delta-HSV or RGB) or ``"statistics"`` (of RGB).
    """

    width: int = 64
    code_dim: int = 8
    style_dim: int = 64
    delta_hsv: bool = True
    substances: int = 4
    periodic: bool = True
    encoder: str = "resnet"


class Encoding(NamedTuple):
    """What the encoder says of crops: ``embedding (n, d)`` and ``logits (n, substances)``."""

    embedding: torch.Tensor
    logits: torch.Tensor | None


class TextureModel(nn.Module):
    """Encoder, substance head and decoder with the state-dict names of the authors' release."""

    def __init__(self, architecture: Architecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.encoder = _make_encoder(architecture)
        self.decoder = Decoder(architecture.style_dim, 2 * OCTAVES * CHANNELS)
        if architecture.substances:
            self.substance_layer = nn.Linear(architecture.code_dim, architecture.substances)

    @property
    def embedding_dim(self) -> int:
        """Length of an embedding: the code, and the median colour where colour is separate."""
        return self.architecture.code_dim + (3 if self.architecture.delta_hsv else 0)

    def encode(self, rgb: torch.Tensor, features: torch.Tensor | None = None) -> Encoding:
        """Return the embeddings and substance logits of crops (n, 3, h, w).

        `features` are what a statistics encoder makes of the crops, where that is known.
        """
        if isinstance(self.encoder, StatisticsEncoder):
            median = colour_torch.median_colour(rgb) if self.architecture.delta_hsv else None
            known = self.encoder.features(rgb) if features is None else features
            return self.embed(self.encoder.code_of_features(known), median)
        if self.architecture.delta_hsv:
            exact = self.architecture.periodic
            return self.encode_hsv(
                colour_torch.rgb_to_hsv(rgb) if exact else colour_torch.rgb_to_hsv_8_bit(rgb)
            )
        return self.embed(self.encoder.code(2.0 * rgb - 1.0), None)

    def encode_hsv(self, hsv: torch.Tensor) -> Encoding:
        """As :meth:`encode`, from HSV (the reference's own input, which has 8 bits)."""
        median = colour_torch.median_colour(colour_torch.hsv_to_rgb(hsv))
        centre = colour_torch.rgb_to_hsv(median[:, :, None, None])
        return self.embed(self.encoder.code(colour_torch.wrap_hue(hsv - centre)), median)

    def embed(self, code: torch.Tensor, median: torch.Tensor | None) -> Encoding:
        """Return the encoding of codes (n, code_dim) and median colours (n, 3), where separate."""
        logits = self.substance_layer(code) if self.architecture.substances else None
        return Encoding(code if median is None else torch.cat([code, median], dim=1), logits)

    def decode(
        self,
        embedding: torch.Tensor,
        seeds: torch.Tensor,
        size_px: int = 128,
        window: tuple[slice, slice] | None = None,
    ) -> torch.Tensor:
        """Return textures (n, 3, size, size), RGB in [0, 1].

        Parameters
        ----------
        embedding : (n, embedding_dim) float32
        seeds : (n, 8, 3) float32
            Uniform in [0, 1), one per octave of noise and colour channel.
        size_px : int
            Side of the tile; more pixels draw the same tile more finely.
        window : two slices, optional
            Rows and columns of the tile to draw; all when None.
        """
        code = embedding[:, : self.architecture.code_dim]
        controls = self.encoder.controls(code)
        periodic = self.architecture.periodic
        grid = position_grid(size_px, periodic=periodic).to(code.device)
        if window is not None:
            grid = grid[:, window[0], window[1]]
        noise_of = torus_noise if periodic else plane_noise
        noise = noise_of(controls[:, :_TRANSFORMS], seeds, grid)
        signed = self.decoder(controls[:, _TRANSFORMS:], noise)
        if not self.architecture.delta_hsv:
            return (signed + 1.0) / 2.0
        median = embedding[:, self.architecture.code_dim :, None, None]
        hsv = colour_torch.rgb_to_hsv(median) + signed
        return colour_torch.hsv_to_rgb(torch.cat([hsv[:, 0:1], hsv[:, 1:].clamp(0.0, 1.0)], dim=1))


def _make_encoder(architecture: Architecture) -> Encoder | StatisticsEncoder:
    """Return the encoder that an architecture names."""
    sizes = (architecture.width, architecture.code_dim, _TRANSFORMS + architecture.style_dim)
    if architecture.encoder == "statistics":
        return StatisticsEncoder(*sizes)
    if architecture.encoder == "resnet":
        return Encoder(*sizes)
    raise ValueError(f"expected an encoder resnet or statistics, found {architecture.encoder!r}")


@contextmanager
def fast_decoding(model: TextureModel) -> Iterator[None]:
    """Decode in bfloat16 within, where that is fast: tiles differ by one level here and there.

    The reference's networks (whose noise does not repeat) return what they return there: float32.
    """
    before = model.decoder.low_precision
    model.decoder.low_precision = model.architecture.periodic and low_precision_is_fast()
    try:
        yield
    finally:
        model.decoder.low_precision = before


def load_texture_model(path: str | Path) -> TextureModel:
    """Return the texture model of a weight file, in evaluation mode."""
    state, architecture = load_model_file(path)
    known = set(Architecture.__dataclass_fields__)
    if set(architecture) != known:
        raise InputError(
            f"a texture model with {sorted(known)}", str(sorted(architecture)), file=path
        )
    name = "a texture model of this architecture"
    return filled(lambda: TextureModel(Architecture(**architecture)), state, name, path)


def architecture_header(model: TextureModel) -> dict[str, int | bool | str]:
    """Return what :func:`plan2scene.weights.save_model_file` stores of a model."""
    return asdict(model.architecture)
