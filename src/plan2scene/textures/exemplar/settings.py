"""Settings of the exemplar method: how crops are chosen, read and quilted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExemplarSettings:
    """Tuned constants. Chosen by looking at tiles of development crops, real and synthetic.

    Lengths in pixels are those of a crop of 128 px unless said otherwise.
    """

    # Which crops show the surface, and sharply.
    #: CIEDE2000 above which two crops show different things; different light gives less
    alike_de: float = 20.0
    #: A crop shows a rug or stripes of sun if its `unrest` (L*a*b*) is at least the first value and
    #: the median crop's is at most the second value times it. Real floors have 5 at most, a rug or
    #: stripes of sun 8 and 13.
    restless: tuple[float, float] = (7.0, 0.4)
    least_sharp: float = 0.2  #: a crop with fewer photo pixels per crop pixel shows no texture
    most_spoiled: float = 0.5  #: share of clipped pixels from which on a crop is useless
    #: A crop is left out if it is more octaves (of photo pixels per metre) below the crop of rank
    #: `enough_sharp`
    few_octaves: float = 1.0
    enough_sharp: int = 3
    max_crops: int = 10  #: largest number of crops in a tile, the best first
    # Faults of a crop. They are added to the standard deviation of the log light taken out of it.
    blur: float = 0.1  #: for each octave fewer photo pixels per metre than the best crop
    faint: float = 0.2  #: for a pattern e times fainter than those of the better crops
    odd: float = 0.5  #: for things e times stronger than `plain` allows
    # The tile.
    #: side of the torus on which tiles of up to this size are quilted; larger tiles: twice as much
    work_px: int = 128
    largest: float = 2.0  #: largest side of the tile over a crop's, before `work_px` is doubled
    smallest_px: int = 32  #: crops with a smaller side on the torus are left out: they make seams
    # The direction in which a pattern runs.
    fine: float = 1.5  #: smallest scale of a pattern, sigma, px
    slow: float = 12.0  #: largest scale of a pattern, sigma, px
    clear: float = 0.2  #: least absolute ``lattice.grain`` of a crop that has a direction
    directed: float = 0.6  #: least share of crops with a direction, so that the surface has one
    # The lattice.
    step_deg: float = 0.25  #: step between the angles that are tried
    spectrum_px: int = 256  #: side of the padded spectrum
    bands: tuple[int, int] = (8, 90)  #: range of radii of the spectrum that hold patterns
    coarse: int = 5  #: smallest radius for a checkerboard, whose first frequencies are lower
    #: least autocorrelation at a period, divided by the square root of the overlap's share
    least_peak: float = 0.25
    least_rise: float = 0.15  #: least rise of the autocorrelation over the valley before the period
    across: float = 0.1  #: least autocorrelation without the lines along the period's direction
    share_of_best: float = 0.8  #: the period is the first lag with this share of the highest peak
    #: Tiles laid diagonally are read along the crop's axes if the peaks there sum to at least this
    #: share of the peaks along the tiles' own axes
    diagonal: float = 0.85
    square: float = 0.08  #: log ratio of the two periods below which tiles are square
    shortest_px: float = 5.0  #: shortest period
    longest: float = 0.8  #: longest period over the crop's side
    same_period: float = 0.12  #: log ratio within which periods of crops of known scale agree
    alike_period: float = 0.3  #: the same where the scale is unknown
    odd_turn_deg: float = 12.0  #: a crop's angle is ignored if it is farther from the usual angle
    enough_periods: int = 3  #: with so many crops of the agreed period the others are left out
    # Things on plain surfaces.
    #: A crop is plain if a high percentile of its absolute pattern over the median is at most this.
    #: Noise and plaster have 5 to 10, a thing on them more, joints of tiles 12 or more.
    plain: float = 10.0
    high: float = 99.97  #: that percentile: an outlet covers a few pixels of a crop
    some: float = 0.25  #: least share of plain crops, so that their surface counts as plain
    part: float = 0.5  #: a thing's part exceeds this share of `plain`: a switch's plate is faint
    halo: float = 0.4  #: a part's pixels exceed this share of its peak; weaker ones are its halo
    around_px: int = 9  #: side of the square that dilates a part, because its band is blurred
    box_rim_px: int = 4  #: rim around a thing's box that is left out with it
    parts: int = 12  #: largest number of parts of all things in a crop
    few: int = 4  #: largest number of things in a crop; a pattern has more
    small: float = 0.35  #: largest side of a thing over the crop's; joints are longer


EXEMPLAR = ExemplarSettings()
