"""What several commands print."""

import json
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from georibbon.notices import Notice
from georibbon.session.words import counted, hidden

if TYPE_CHECKING:
    from georibbon.geometry.surface import Surface
    from georibbon.reconstruction import Reconstruction


def json_text(facts: Mapping[str, object]) -> str:
    """One JSON object in lines; what would steer a terminal, or is no text, is escaped."""
    text = json.dumps(facts, indent=2, ensure_ascii=False)
    return "".join(map(_escaped, text))


def _escaped(character: str) -> str:
    if character.isascii() and character != "\x7f":
        return character  # JSON has escaped these
    surrogate = "\ud800" <= character <= "\udfff"
    if not surrogate and not hidden(character):
        return character
    return json.dumps(character)[1:-1] if character != "\x7f" else "\\u007f"


def print_notices(notices: Iterable[Notice]) -> None:
    """Each notice in one line, with its code and what it is about."""
    for notice in notices:
        about = ", ".join(filter(None, (notice.pass_name, notice.sensor)))
        print(f"notice: {notice.code}{f' ({about})' if about else ''}: {notice.message}")


def print_reconstruction(result: "Reconstruction") -> None:
    """The result in a few lines: each pass, the survey, the surface, the notices."""
    from georibbon.export.summary import all_notices

    for fitted in result.passes:
        sigma = fitted.position_sigma
        rms = math.hypot(*sigma) / math.sqrt(len(sigma))
        length = fitted.strip.s[-1] - fitted.strip.s[0]
        print(
            f"{fitted.name:8} {fitted.kind:5} {length:.3f} m  "
            f"sigma {1e3 * rms:.2f} mm  smoothing {1e3 * fitted.smoothing:.0f} mm  "
            f"{fitted.quality.verdict}: {fitted.quality.reason}"
        )
    if result.survey:
        ratio = math.sqrt(sum(seen.ratio**2 for seen in result.survey) / len(result.survey))
        seen = counted(len(result.survey), "observation")
        print(f"survey   {seen}, missed by {ratio:.2f} of their standard deviations (rms)")
    if result.surface is not None:
        print_surface(result.surface)
    print_notices(all_notices(result))


def print_surface(surface: "Surface") -> None:
    """Its size, and every check that is not passed."""
    triangles = counted(len(surface.mesh.triangles), "triangle")
    passed = sum(check.verdict == "pass" for check in surface.checks)
    print(
        f"surface  {surface.area:.4f} m², {triangles}, "
        f"{passed} of {counted(len(surface.checks), 'check')} passed"
    )
    for check in surface.checks:
        if check.verdict != "pass":
            print(f"check {check.verdict}: {check.code} ({check.where}): {check.message}")
