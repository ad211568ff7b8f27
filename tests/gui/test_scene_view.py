"""The 3D view."""

import synthetic
from georibbon.gui.scene_view import make_view


def test_a_result_is_shown(qtbot):
    view = make_view()
    qtbot.addWidget(view)
    view.resize(480, 300)
    view.show_scene(synthetic.reconstruction())
    image = view.image()
    assert image.width() == 480
    seen = {image.pixelColor(x, 150).rgb() for x in range(0, 480, 10)}
    assert len(seen) > 10
