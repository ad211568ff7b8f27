"""Figures 2 and 3: one patch between two curves, and what its tangent lengths do."""

from georibbon.geometry.frames import Strip
from georibbon.paper_figures.building import (
    DEFAULT,
    Built,
    conormal_arrows,
    facing,
    laid_by,
    laid_plainly,
    length_numbers,
    line_numbers,
    model_of,
    shape_numbers,
    verdict_of,
)
from georibbon.paper_figures.curves import binormals, half_ellipse, strip_along, twisted_arc
from georibbon.paper_figures.figure import Choice, Figure, Whose

LENGTHS = ((1.0, 1.0), (3.0, 1.0), (1.0, 3.0), (0.3, 0.3))


def half_ellipses() -> list[Strip]:
    """Two half ellipses in parallel planes 0.18 m apart."""
    jets = half_ellipse(-0.09, 0.25, 0.18), half_ellipse(0.09, 0.15, 0.09)
    return facing([strip_along(jet, binormals(jet)) for jet in jets])


def figure_2() -> Figure:
    """The tangent lengths of a patch between two half ellipses."""
    strips = half_ellipses()
    choices = [
        _choice(
            f"λ0 = {first:g}, λ1 = {second:g}",
            "paper",
            f"chord, {first:g} {second:g}, equal parameters",
            laid_plainly(strips, "chord", (first, second)),
            strips,
        )
        for first, second in LENGTHS
    ]
    choices.append(_choice("Georibbon's default", "georibbon", DEFAULT, laid_by(strips), strips))
    return Figure(
        2,
        "Tangent lengths",
        "Two half ellipses, 0.50 by 0.18 m and 0.30 by 0.09 m, in parallel planes 0.18 m apart; "
        "the lines across leave along the chord brought into the tangent plane.",
        "How a patch between two curves changes with the lengths of its starting and arrival "
        "vectors: long ones make it full near their curve, short ones make it flat.",
        "A length is the speed at which a line leaves, so a long one crowds the surface's lines "
        "to its side and a short one makes them straight; none of these folds. Lengths of an arc "
        "lie near 1 here: nobody has to choose them.",
        tuple(choices),
        towards=(-0.8, -0.75, 1.1),
        main=("start_speed", "middle_speed", "end_speed", "line_length"),
    )


def twisted_arcs() -> list[Strip]:
    """Two arcs of 0.3 m that lean towards different sides and leave their planes."""
    jets = twisted_arc(-0.11, -0.25, 0.02), twisted_arc(0.11, 0.30, -0.03)
    return facing([strip_along(jet, binormals(jet)) for jet in jets])


def figure_3() -> Figure:
    """Two twisted arcs joined along their binormals."""
    strips = twisted_arcs()
    choices = [
        _choice(
            f"binormals, λ = {factor:g}",
            "paper",
            f"conormal, {factor:g} {factor:g}, equal parameters",
            laid_plainly(strips, "conormal", (factor, factor)),
            strips,
        )
        for factor in (1.0, 0.4)
    ]
    choices.append(_choice("Georibbon's default", "georibbon", DEFAULT, laid_by(strips), strips))
    return Figure(
        3,
        "Two twisted curves",
        "Two arcs of 0.30 m radius and 1.8 rad, 0.22 m apart, that lean to different sides and "
        "leave their planes; the lines across leave along the binormals.",
        "A patch between two curves that are not plane, with starting and arrival vectors along "
        "their binormals, so that both curves are geodesics of it.",
        "All are whole; none comes near a fold.",
        tuple(choices),
        main=("tear_ratio", "sine_least", "line_length"),
    )


def _choice(name: str, whose: Whose, settings: str, built: Built, strips: list[Strip]) -> Choice:
    numbers = {**line_numbers(built), **length_numbers(built), **shape_numbers(built)}
    arrows = conormal_arrows(strips, 0.03, every=12)
    return Choice(
        name, whose, settings, numbers, verdict_of(numbers), model_of(built, strips, arrows=arrows)
    )
