"""Figures 4 to 6: starting vectors along binormals, where binormals turn over or round."""

from georibbon.geometry.frames import Strip, unit
from georibbon.geometry.framing import framed
from georibbon.geometry.frenet import continued
from georibbon.paper_figures.building import (
    DEFAULT,
    Built,
    conormal_arrows,
    facing,
    laid_by,
    laid_plainly,
    model_of,
    normal_jump,
    shape_numbers,
    verdict_of,
)
from georibbon.paper_figures.curves import (
    binormals,
    flat_arc,
    screw,
    strip_along,
    towards,
    waved,
)
from georibbon.paper_figures.figure import Choice, Figure, Whose

ALONG_BINORMALS = "conormal, 1 1, equal parameters"


def waves() -> tuple[list[Strip], list[Strip]]:
    """Two plane S-curves 0.24 m apart: with their binormals as they come, and kept turning."""
    jets = waved(-0.12, 0.05), waved(0.12, 0.035, 0.3)
    raw = [strip_along(jet, binormals(jet)) for jet in jets]
    kept = [strip_along(jet, continued(binormals(jet))) for jet in jets]
    return raw, facing(kept)


def figure_4() -> Figure:
    """The tear at an inflection."""
    raw, _ = waves()
    return Figure(
        4,
        "Binormals at an inflection",
        "Two plane S-curves, 0.52 m long, 50 and 35 mm high to either side, in parallel planes "
        "0.24 m apart; only their points are given.",
        "A surface that breaks apart at the inflections, where the binormals that it starts from "
        "turn over.",
        "Binormals as the curves give them tear the surface. Georibbon's frames from a curve "
        "alone do not know the binormal's sign at all, so there is nothing that could turn over.",
        (
            _along_binormals("binormals as they come", raw, facing(raw)),
            _by_default(raw),
        ),
        main=("tear_ratio", "self_crossing_pairs", "fold_least", "normal_jump_deg"),
    )


def figure_5() -> Figure:
    """The same without a tear."""
    _, kept = waves()
    return Figure(
        5,
        "Binormals kept from turning over",
        "The curves of figure 4; a binormal that points away from the one before it is turned "
        "round.",
        "The same two curves with starting vectors that go on continuously through the "
        "inflections: a whole surface.",
        "On exact curves the plain rule is enough, and both surfaces are whole. On measured ones "
        "it is not: see figures 12 and 13.",
        (
            _along_binormals("binormals kept", kept),
            _by_default(kept),
        ),
        main=("tear_ratio", "self_crossing_pairs", "fold_least", "normal_jump_deg"),
    )


def turning() -> tuple[list[Strip], list[Strip]]:
    """A slender screw of one turn beside an arc, its binormals towards the arc, or kept turning."""
    jets = screw(0.03, 0.6, 1.0), flat_arc(0.2, 0.6, 0.6)
    ahead = unit(jets[1].points - jets[0].points)
    arc = strip_along(jets[1], binormals(jets[1]))
    facing_arc = strip_along(jets[0], towards(binormals(jets[0]), ahead))
    kept = strip_along(jets[0], continued(binormals(jets[0])))
    return facing([facing_arc, arc]), facing([kept, arc])


def figure_6() -> Figure:
    """A binormal that turns once round its curve."""
    facing_strips, kept = turning()
    return Figure(
        6,
        "A binormal that turns round once",
        "A slender screw of one turn, 0.60 m long, 30 mm in radius, beside an arc 0.20 m away; the "
        "screw's binormal turns once round it.",
        "Two surfaces, neither of them good: starting vectors held towards the other curve make "
        "it break, continuous ones make it run through itself.",
        "No choice is whole here, for the curves ask for a surface that winds round. The chord "
        "brought into the tangent plane tears it as well; the default keeps it in one piece, and "
        "its checks say that it runs through itself.",
        (
            _along_binormals("binormals towards the arc", facing_strips),
            _along_binormals("binormals kept", kept),
            _choice(
                "along the chord",
                "paper",
                "chord, 1 1, equal parameters",
                laid_plainly(kept, "chord", (1.0, 1.0)),
                kept,
            ),
            _choice(
                "safe chord, λ = 1",
                "other",
                "safe-chord, 1 1, equal parameters",
                laid_plainly(kept, "safe-chord", (1.0, 1.0)),
                kept,
            ),
            _by_default(kept),
        ),
        main=("tear_ratio", "self_crossing_pairs", "fold_least", "normal_jump_deg"),
    )


def _by_default(strips: list[Strip]) -> Choice:
    """From the points alone, by the frames and the surface that are the default."""
    found = facing([framed(one.points) for one in strips])
    return _choice(
        "Georibbon's default",
        "georibbon",
        f"normals doubled-angle; {DEFAULT}",
        laid_by(found),
        found,
    )


def _along_binormals(name: str, strips: list[Strip], shown: list[Strip] | None = None) -> Choice:
    """The paper's way: tangents along the binormals, as long as the chord.

    shown: the strips whose normals are drawn and measured, where they are others.
    """
    built = laid_plainly(strips, "conormal", (1.0, 1.0))
    return _choice(name, "paper", ALONG_BINORMALS, built, shown or strips)


def _choice(name: str, whose: Whose, settings: str, built: Built, strips: list[Strip]) -> Choice:
    numbers = {**shape_numbers(built), "normal_jump_deg": normal_jump(strips)}
    drawing = model_of(built, strips, arrows=conormal_arrows(strips, 0.045))
    return Choice(name, whose, settings, numbers, verdict_of(numbers), drawing)
