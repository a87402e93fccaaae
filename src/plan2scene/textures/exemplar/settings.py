"""Settings of the exemplar method: how crops are chosen, read and quilted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExemplarSettings:
    """Tuned constants. Chosen by looking at tiles of development crops, real and synthetic.

    Lengths in pixels are those of a crop of 128 px unless said otherwise.
    """

    # Which crops show the surface, and sharply.
    #: CIEDE2000 beyond which crops are of different things; light gives less
    alike_de: float = 20.0
    #: How much a crop varies (L*a*b*, `unrest`) that shows a rug or stripes of sun, where the usual
    #: one varies by less than a share of it. Real floors vary by 5 at most, the others by 8 and 13.
    restless: tuple[float, float] = (7.0, 0.4)
    least_sharp: float = 0.2  #: photo pixels per crop pixel under which a crop shows no texture
    most_spoiled: float = 0.5  #: share of clipped pixels from which on a crop is useless
    #: crops blurred by more than this against the better ones are left out
    few_octaves: float = 1.0
    enough_sharp: int = 3  #: where so many are sharper
    max_crops: int = 10  #: that take part, the best first
    # What counts against a crop, in standard deviations of the log light that was taken out of it.
    blur: float = 0.1  #: an octave fewer photo pixels a metre
    faint: float = 0.2  #: a pattern e times fainter than the better ones
    odd: float = 0.5  #: things e times stronger than a plain surface's pattern
    # The tile.
    #: side of the torus for tiles of up to this size; larger ones: twice as much
    work_px: int = 128
    largest: float = 2.0  #: side of the tile over the side of a crop
    smallest_px: int = 32  #: crops that fill less of the tile only make seams
    # The direction in which a pattern runs.
    fine: float = 1.5  #: smallest scale of a pattern, sigma, px
    slow: float = 12.0  #: largest scale of a pattern, sigma, px
    clear: float = 0.2  #: grain from which on a crop has a direction
    directed: float = 0.6  #: share of the crops that need one for the surface to have one
    # The lattice.
    step_deg: float = 0.25  #: of the angles that are tried
    spectrum_px: int = 256  #: side of the padded spectrum
    bands: tuple[int, int] = (8, 90)  #: radii of it that hold patterns
    coarse: int = 5  #: least radius for a checkerboard, whose first frequencies are low
    least_peak: float = 0.25  #: autocorrelation of a period, over the root of the overlap's share
    least_rise: float = 0.15  #: and its rise over the valley before it
    across: float = 0.1  #: autocorrelation left without the lines along the period's direction
    share_of_best: float = 0.8  #: the smallest lag this near to the best one is the period
    diagonal: float = 0.85  #: share of the upright pattern's peaks that a diagonal one needs
    square: float = 0.08  #: log ratio of the sides of square tiles
    shortest_px: float = 5.0  #: period
    longest: float = 0.8  #: period over the crop's side
    same_period: float = 0.12  #: log ratio within which periods of crops of known scale agree
    alike_period: float = 0.3  #: the same where the scale is unknown
    odd_turn_deg: float = 12.0  #: from the usual turn; beyond it a crop's angle is not believed
    enough_periods: int = 3  #: crops of the agreed period; with so many the others are left out
    # Things on plain surfaces.
    #: High percentile over the median of what a crop's pattern varies by: noise and plaster have 5
    #: to 10, a thing on them more, as do joints of tiles (from 12 on).
    plain: float = 10.0
    high: float = 99.97  #: that percentile: an outlet has a few pixels of a crop
    some: float = 0.25  #: share of the crops that have to be plain for their surface to be so
    part: float = 0.5  #: of what makes a thing its fainter parts have at least: a switch's plate
    halo: float = 0.4  #: of a part's peak, under which it is a halo
    around_px: int = 9  #: over which a part spreads: the pattern's band is blurred
    box_rim_px: int = 4  #: about a thing's box that go with it
    parts: int = 12  #: of all things
    few: int = 4  #: things in a crop at most; a pattern has more
    small: float = 0.35  #: side of a thing over the crop's, at most; joints are longer


EXEMPLAR = ExemplarSettings()
