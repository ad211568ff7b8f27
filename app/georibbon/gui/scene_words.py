"""The words that stand in the 3D scene, marked for translation; the scene knows no window."""

from georibbon.gui.language import N_

SCENE_WORDS = frozenset({
    N_("Position\nuncertainty\n1σ, {unit}\n"),
    N_("Gaussian\ncurvature\n1/m²\n"),
    N_("Mean\ncurvature\n1/m\n"),
    N_("Curvature\nalong passes\n1/m\n"),
    N_("Deviation\n{words}{unit}\n"),
    N_("pass"),
    N_("tie"),
    N_("mark or crossing"),
    N_("measured distance"),
    N_("being laid"),
    N_("its neighbour"),
    N_("sensor"),
    N_("sensor left out"),
    N_("nothing to compare with"),
    N_("grid, {cell}"),
})  # fmt: skip
