"""``georibbon compare``: how one surface lies from another."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from georibbon.cli.arguments import Parser, millimetres
from georibbon.cli.outputs import Outputs, signals_held
from georibbon.cli.printing import json_text
from georibbon.errors import SettingsError
from georibbon.export.files import require_ending

if TYPE_CHECKING:
    from georibbon.export.comparison import Comparison
    from georibbon.reconstruction import Reconstruction

DESCRIPTION = """\
Reconstruct FIRST and tell how its surface lies from that of SECOND: another session or
recording, or a mesh file (.stl, .obj, .ply).  Each place of FIRST is compared with the
nearest point of SECOND; positive is on its outer side.  What SECOND does not cover is left
out, and told.

Both are taken as they lie in their workpiece frames.  With --align FIRST is laid onto
SECOND as well as it goes before, which is told too: use it where the frames differ."""

EPILOG = """\
examples:
  georibbon compare monday.georibbon tuesday.georibbon
  georibbon compare bonnet.georibbon cad.stl --unit mm --align --report bonnet-cad.html
  georibbon compare a.georibbon b.georibbon --tolerance 0.3 --json     # for programs"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "first", metavar="FIRST", type=Path, help="recording folder or .georibbon session"
    )
    parser.add_argument("second", metavar="SECOND", type=Path, help="the same, or a mesh file")
    parser.add_argument(
        "--unit", choices=("mm", "cm", "m", "in"),
        help="of the numbers in a mesh file (default mm)",
    )  # fmt: skip
    parser.add_argument(
        "--tolerance", metavar="MM", type=millimetres, default=5e-4,
        help="the share of the area within it is told (default 0.5)",
    )  # fmt: skip
    parser.add_argument(
        "--align", action="store_true",
        help="lay FIRST onto SECOND before, by a rigid motion",
    )  # fmt: skip
    parser.add_argument(
        "--report", metavar="FILE", type=Path, action="append", default=[],
        help=".html or .pdf for people, .json for programs; may be repeated",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Compare, write what was asked for, print the figures."""
    from georibbon.export.comparison import (
        compare,
        comparison_data,
        is_mesh_file,
        read_other,
    )

    for path in arguments.report:
        require_ending(path, (".html", ".pdf", ".json"), "a comparison")
    if arguments.unit and not is_mesh_file(arguments.second):
        raise SettingsError("--unit is of a mesh file; sessions and recordings know their own")
    inputs = (arguments.first, arguments.second)
    with Outputs(arguments.report, inputs=inputs) as outputs:
        first = read_other(arguments.first)
        if first.result is None:
            raise SettingsError(f"{arguments.first}: a mesh file is SECOND; give the session first")
        other = read_other(arguments.second, arguments.unit or "mm")
        found = compare(first.result, first.name, other, arguments.tolerance, arguments.align)
        data = comparison_data(found, first.result)
        for path in arguments.report:
            _write(path, outputs.place(path), found, first.result, data)
    print(json_text(data) if arguments.json else "\n".join(lines(data)))
    if not arguments.json:
        for path in arguments.report:
            print(f"written: {path}")


def _write(
    path: Path, place: Path, found: "Comparison", first: "Reconstruction", data: dict[str, Any]
) -> None:
    from georibbon.export.files import write_whole

    ending = path.suffix.lower()
    if ending == ".json":
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        write_whole(place, text.encode("utf-8"))
        return
    with signals_held():
        if ending == ".pdf":
            from georibbon.export.comparison_pdf import comparison_pdf

            whole = comparison_pdf(found, first, data)
        else:
            from georibbon.export.comparison_page import comparison_html

            whole = comparison_html(found, first, data).encode("utf-8")
    write_whole(place, whole)


def lines(data: dict[str, Any]) -> list[str]:
    """The comparison for a person."""
    told = [f"{data['first']} from {data['second']}"]
    aligned, found = data["aligned"], data["deviation"]
    if aligned:
        shift = 1e3 * sum(one**2 for one in aligned["translation_m"]) ** 0.5
        told.append(
            f"laid onto it first: turned {aligned['turned_deg']:.3f}°, moved {shift:.2f} mm"
        )
    if found is None:
        return [*told, "they have no place in common; is the frame another? try --align"]
    told.append(
        f"deviation mean {found['mean_mm']:+.3f} mm, rms {found['rms_mm']:.3f} mm, 95 % within "
        f"{found['p95_mm']:.3f} mm, from {found['lowest_mm']:+.3f} to {found['highest_mm']:+.3f} mm"
    )
    told.append(
        f"{100 * found['within']:.1f} % of the area within {found['tolerance_mm']:g} mm; "
        f"{100 * found['covered']:.1f} % is covered by the other"
    )
    for pair in data["passes"]:
        one, other = (_pass(pair[side]) for side in ("first", "second"))
        told.append(f"{pair['name']:8} {one:32} | {other}".rstrip(" |"))
    return told


def _pass(one: dict[str, Any] | None) -> str:
    if one is None:
        return ""
    sigma, smoothing = one["position_sigma_mm"], one["smoothing_mm"]
    return f"{one['quality']}, sigma {sigma:.2f} mm, smoothing {smoothing:.0f} mm"
