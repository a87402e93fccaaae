"""The texture model: crop -> 11 numbers -> seamless texture (paper section 5.2, Figure 3).

With ``delta_hsv`` it is the paper's Synth: the network reads and makes HSV offsets from the crop's
median colour, and the embedding is the bottleneck code followed by the median RGB. Without, it is
NaiveSynth, the unmodified model of Henzler et al. (2020), whose embedding is the code alone.

The encoder is the paper's ResNet-18 with instance normalisation, or one that reads the energies of
a fixed filter bank and the spectrum instead of learned features. The latter learns from about two
thousand textures in minutes on a CPU; the residual network needs orders of magnitude more steps.
The decoder is a small network applied to the noise at every pixel. Images are
``(n, 3, h, w) float32`` RGB in [0, 1].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from plan2scene.errors import InputError
from plan2scene.textures.model import hsv as hsv_space
from plan2scene.textures.model.noise import (
    CHANNELS,
    OCTAVES,
    plane_noise,
    position_grid,
    torus_noise,
)
from plan2scene.textures.model.statistics import (
    FilterBankStatistics,
    SpectrumStatistics,
    colour_quantiles,
    moments_of,
)
from plan2scene.weights import filled, load_model_file


class _Layer(nn.Module):
    """Holds a 1x1 convolution under the name that checkpoints use (``...layer.weight``)."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.layer = nn.Conv2d(inputs, outputs, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return (n, pixels, outputs) of (n, pixels, inputs), computed in the dtype of `x`."""
        weight, bias = self.layer.weight[:, :, 0, 0], self.layer.bias
        return functional.linear(x, weight.to(x.dtype), None if bias is None else bias.to(x.dtype))


class Decoder(nn.Module):
    """Style (n, style_dim) and noise (n, noise_maps, h, w) -> (n, 3, h, w) in [-1, 1].

    Layers of 128 channels. `low_precision` multiplies in bfloat16 (three times faster on CPUs
    that have it; weights stay float32).
    """

    def __init__(self, style_dim: int, noise_maps: int = 2 * OCTAVES * CHANNELS) -> None:
        super().__init__()
        width = 128
        self.style_dim = style_dim
        self.low_precision = False
        self.first_conv = _Layer(style_dim + noise_maps, width)
        self.res_blocks = nn.ModuleList(_Layer(width, width) for _ in range(4))
        self.last_conv = _Layer(width, 3)

    def forward(self, style: torch.Tensor, noise: torch.Tensor) -> torch.Tensor:
        """Return tanh of the network's output, (n, 3, h, w) float32."""
        n, _, h, w = noise.shape
        dtype = torch.bfloat16 if self.low_precision else noise.dtype
        pixels = noise.to(dtype).flatten(2).transpose(1, 2)  # (n, h w, noise_maps)
        first = self.first_conv.layer
        weight = first.weight[:, :, 0, 0]
        # The style is constant over the tile, so the first layer adds it as a bias per texture.
        bias = functional.linear(style, weight[:, : self.style_dim], first.bias)
        y = pixels @ weight[:, self.style_dim :].T.to(dtype) + bias.to(dtype).unsqueeze(1)
        y = functional.relu(y, inplace=True)
        for block in self.res_blocks:
            y = functional.relu(block(y), inplace=True)
        y = torch.tanh(self.last_conv(y).float())
        return y.transpose(1, 2).reshape(n, 3, h, w)


def low_precision_is_fast() -> bool:
    """Return whether this processor multiplies bfloat16 natively."""
    return bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())


class BasicBlock(nn.Module):
    """Two 3x3 convolutions with a shortcut; names follow torchvision's checkpoints."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.norm = nn.InstanceNorm2d(outputs)
        self.downsample: nn.Sequential | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.InstanceNorm2d(outputs)
            )

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return (n, outputs, h / stride, w / stride) of (n, inputs, h, w)."""
        shortcut = x if self.downsample is None else self.downsample(x)
        y = functional.relu(self.norm(self.conv1(x)))
        return functional.relu(self.norm(self.conv2(y)) + shortcut)


class Encoder(nn.Module):
    """Crop (n, 3, h, w) -> bottleneck code (n, code_dim) and decoder controls (n, control_dim).

    With a stem of `width` 64 it is ResNet-18 and fits the authors' checkpoints. Codes of 8 and
    controls of 96 (transform coefficients and style values together) are the paper's.
    """

    def __init__(self, width: int = 64, code_dim: int = 8, control_dim: int = 96) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
        self.norm = nn.InstanceNorm2d(width)
        self.layer1 = self._layer(width, width, 1)
        self.layer2 = self._layer(width, 2 * width, 2)
        self.layer3 = self._layer(2 * width, 4 * width, 2)
        self.layer4 = self._layer(4 * width, 8 * width, 2)
        self.fc_bottleneck = nn.Linear(8 * width, code_dim)
        self.fc_final = nn.Linear(code_dim, control_dim)

    @staticmethod
    def _layer(inputs: int, outputs: int, stride: int) -> nn.Sequential:
        return nn.Sequential(BasicBlock(inputs, outputs, stride), BasicBlock(outputs, outputs, 1))

    def code(self, x: torch.Tensor) -> torch.Tensor:
        """Return the bottleneck code (n, code_dim) of (n, 3, h, w)."""
        y = functional.relu(self.norm(self.conv1(x)))
        y = functional.max_pool2d(y, 3, 2, 1)
        y = self.layer4(self.layer3(self.layer2(self.layer1(y))))
        return self.fc_bottleneck(y.mean(dim=(2, 3)))

    def controls(self, code: torch.Tensor) -> torch.Tensor:
        """Return the decoder's controls (n, control_dim) of codes (n, code_dim)."""
        return self.fc_final(code)


class StatisticsEncoder(nn.Module):
    """Crop (n, 3, h, w) -> code and controls as :class:`Encoder`, through fixed statistics.

    The statistics are moments of the fixed filter bank's responses at four levels, log power by
    sector of the spectrum and the colours' distribution. They are standardised (buffers, set once
    from examples); a network of one hidden layer of `width` follows. It reads the colour even if
    the code need not encode it, because wood is recognised by its colour.
    """

    def __init__(self, width: int, code_dim: int, control_dim: int) -> None:
        super().__init__()
        self.dropout = 0.0
        # On the CPU even if the network is built on the device "meta": to compute there, torch
        # would load its compiler, which takes as long as torch itself.
        with torch.device("cpu"), torch.no_grad():
            self.filters = FilterBankStatistics()
            self.spectrum = SpectrumStatistics()
            count = self.features(torch.zeros(1, 3, 128, 128)).shape[1]
        self.centre: torch.Tensor
        self.scale: torch.Tensor
        self.register_buffer("centre", torch.zeros(count))
        self.register_buffer("scale", torch.ones(count))
        self.hidden = nn.Linear(count, width)
        self.fc_bottleneck = nn.Linear(width, code_dim)
        self.fc_final = nn.Linear(code_dim, control_dim)

    def features(
        self, rgb: torch.Tensor, responses: Sequence[torch.Tensor] | None = None
    ) -> torch.Tensor:
        """Return the statistics (n, k) of crops (n, 3, 128, 128), RGB in [0, 1].

        They are the same for all encoders of this kind. `responses` are those of `filters` to the
        crops, if they are already computed.
        """
        moments = moments_of(self.filters.responses(rgb) if responses is None else responses)
        luminance, chroma = self.spectrum.log_power(rgb)
        parts = [moments, luminance, chroma.flatten(1), colour_quantiles(rgb)]
        return torch.cat(parts, dim=1)

    def standardise(self, features: torch.Tensor) -> None:
        """Set centre and scale from the features (n, k) of example crops."""
        self.centre.copy_(features.mean(0))
        self.scale.copy_(features.std(0) + 1e-3)

    def code_of_features(self, features: torch.Tensor) -> torch.Tensor:
        """Return codes (n, code_dim) of statistics (n, k)."""
        # Clamped, so that crops unlike all examples stay in the range that the network has seen.
        x = ((features - self.centre) / self.scale).clamp(-4.0, 4.0)
        hidden = functional.dropout(functional.relu(self.hidden(x)), self.dropout, self.training)
        return self.fc_bottleneck(hidden)

    def code(self, x: torch.Tensor) -> torch.Tensor:
        """Return the bottleneck code (n, code_dim) of RGB crops (n, 3, 128, 128)."""
        return self.code_of_features(self.features(x))

    def controls(self, code: torch.Tensor) -> torch.Tensor:
        """Return the decoder's controls (n, control_dim) of codes (n, code_dim)."""
        return self.fc_final(code)


_TRANSFORMS = OCTAVES * 4


@dataclass(frozen=True)
class Architecture:
    """The arguments of a texture model's constructor."""

    width: int = 64  #: channels of the residual encoder's stem (64: the paper's), or hidden units
    code_dim: int = 8  #: length of the bottleneck's code
    style_dim: int = 64
    delta_hsv: bool = True  #: True: colour apart from pattern, as in the paper; False: NaiveSynth
    substances: int = 4  #: classes of the substance head, 0 for none
    #: True: noise on a torus, so that textures tile; False: the reference's noise and 8-bit HSV
    periodic: bool = True
    #: ``resnet`` (the paper's, of delta-HSV or RGB) or ``statistics`` (of RGB)
    encoder: str = "resnet"


class Encoding(NamedTuple):
    """The encoder's output for crops: ``embedding (n, d)`` and ``logits (n, substances)``."""

    embedding: torch.Tensor
    logits: torch.Tensor | None


class TextureModel(nn.Module):
    """Encoder, substance head and decoder with the state-dict names of the authors' release."""

    def __init__(self, architecture: Architecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.encoder = _make_encoder(architecture)
        self.decoder = Decoder(architecture.style_dim)
        if architecture.substances:
            self.substance_layer = nn.Linear(architecture.code_dim, architecture.substances)

    @property
    def embedding_dim(self) -> int:
        """Length of an embedding: the code, plus the median colour with ``delta_hsv``."""
        return self.architecture.code_dim + (3 if self.architecture.delta_hsv else 0)

    def encode(self, rgb: torch.Tensor, features: torch.Tensor | None = None) -> Encoding:
        """Return the embeddings and substance logits of crops (n, 3, h, w).

        `features` are a statistics encoder's features of the crops, if already computed.
        """
        if isinstance(self.encoder, StatisticsEncoder):
            median = hsv_space.median_colour(rgb) if self.architecture.delta_hsv else None
            known = self.encoder.features(rgb) if features is None else features
            return self.embed(self.encoder.code_of_features(known), median)
        if self.architecture.delta_hsv:
            exact = self.architecture.periodic
            return self.encode_hsv(
                hsv_space.rgb_to_hsv(rgb) if exact else hsv_space.rgb_to_hsv_8_bit(rgb)
            )
        return self.embed(self.encoder.code(2.0 * rgb - 1.0), None)

    def encode_hsv(self, hsv: torch.Tensor) -> Encoding:
        """Return what :meth:`encode` does, from HSV (the reference's input, which has 8 bits)."""
        median = hsv_space.median_colour(hsv_space.hsv_to_rgb(hsv))
        centre = hsv_space.rgb_to_hsv(median[:, :, None, None])
        return self.embed(self.encoder.code(hsv_space.wrap_hue(hsv - centre)), median)

    def embed(self, code: torch.Tensor, median: torch.Tensor | None) -> Encoding:
        """Return the encoding of codes (n, code_dim) and of median colours (n, 3) or None."""
        logits = self.substance_layer(code) if self.architecture.substances else None
        return Encoding(code if median is None else torch.cat([code, median], dim=1), logits)

    def decode(
        self,
        embedding: torch.Tensor,
        seeds: torch.Tensor,
        size_px: int = 128,
        window: tuple[slice, slice] | None = None,
    ) -> torch.Tensor:
        """Return textures (n, 3, size, size), RGB in [0, 1], of embeddings (n, d) float32.

        `seeds` (n, 8, 3) float32 are uniform in [0, 1), one per octave of noise and colour channel.
        A larger size draws the same tile more finely. `window` is the rows and the columns to draw;
        None: all.
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
        hsv = hsv_space.rgb_to_hsv(median) + signed
        return hsv_space.hsv_to_rgb(torch.cat([hsv[:, 0:1], hsv[:, 1:].clamp(0.0, 1.0)], dim=1))


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
    """Decode in bfloat16 within this context, if that is fast: a few pixels differ by one level.

    Networks with the reference's noise, which does not repeat, still decode in float32, so that
    they return what they return in the reference.
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


#: Largest number of pixels, about, that are decoded at once (bounds memory at any size).
_PIXELS = 4 * 128 * 128


def noise_seeds(seeds: Sequence[int]) -> torch.Tensor:
    """Return noise seeds (n, 8, 3) float32 in [0, 1), each from its own integer seed."""
    draws = [np.random.default_rng(s).random((OCTAVES, CHANNELS), dtype=np.float32) for s in seeds]
    return torch.from_numpy(np.stack(draws))


def decode_textures(
    model: TextureModel, codes: np.ndarray, seeds: Sequence[int], size_px: int = 128
) -> np.ndarray:
    """Return tiles (n, size, size, 3) uint8 sRGB of embeddings (n, d); same seed, same tile.

    Colours are clamped to [0, 1]; each seed decides the noise of one tile. A larger size draws the
    same tile with more pixels. Processors without fast bfloat16 multiply in float32: a few pixels
    of their tiles differ by one level (docs/conventions.md: same seed, same bytes).
    """
    values = torch.from_numpy(np.asarray(codes, dtype=np.float32).copy())
    code_dim = model.architecture.code_dim
    values[:, code_dim:] = values[:, code_dim:].clamp(0.0, 1.0)
    tiles = np.empty((len(codes), size_px, size_px, 3), dtype=np.uint8)
    step = max(1, _PIXELS // size_px**2)
    with torch.inference_mode(), fast_decoding(model):
        for start in range(0, len(codes), step):
            part = slice(start, start + step)
            rgb = model.decode(values[part], noise_seeds(seeds[part]), size_px)
            pixels = (rgb.clamp(0.0, 1.0) * 255.0).round().to(torch.uint8)
            tiles[part] = pixels.permute(0, 2, 3, 1).numpy()
    return tiles
