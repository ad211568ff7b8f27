"""The whole surface for CAD programs: one B-spline face as STEP or IGES.

Written by the Open CASCADE kernel, which is an extra of Georibbon's (`cad`): it is
large, and nothing else needs it.  It is only loaded when a file is written.
Every file is read again by the kernel before it is put in its place, and the
surface that comes back is held against what was to be written.
"""

import importlib
import importlib.util
import re
import sys
import tempfile
import threading
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import georibbon
from georibbon.arrays import FloatArray
from georibbon.errors import ExportError
from georibbon.export.files import CAD_ENDINGS, require_ending, write_whole
from georibbon.export.mesh import Unit
from georibbon.geometry.one_spline import DEGREE, OneSpline, one_spline
from georibbon.geometry.patch import PatchSet

READ_BACK = 1e-7  # m: what a file's digits may cost
LONGEST_NAME = 60
_MM = 1000.0  # the kernel's own unit is the millimetre
_STEP_UNITS = {"mm": "MM", "cm": "CM", "m": "M", "in": "INCH"}
_IGES_UNITS = {"mm": "MM", "cm": "CM", "m": "M", "in": "INCH"}
_STEP = (".step", ".stp")
_SCHEMA = "AP214IS"
_CLOSE = 1e-4  # mm, told in the file: within this distance points are the same
_LOOKED_AT = 3  # places between neighbouring knots where the file is held against the spline
_MOST_LOOKED_AT = 300  # in either direction
_KERNEL = "OCP"
_ONE_AT_A_TIME = threading.Lock()  # the kernel's settings are its process's


@dataclass(frozen=True)
class CadFacts:
    """What was written: one face.

    deviation: metres, turn: radians, that the spline lies within from the
    patches, its normals from theirs.  count: of control points, along and
    across.  smooth: whether the spline is continuously differentiable, or its
    lines across have corners at the passes (within the tangent plane).
    read_back: metres, the largest distance of what was read from the file again.
    """

    deviation: float
    turn: float
    count: tuple[int, int]
    smooth: bool
    read_back: float


def what_lacks() -> str | None:
    """What to do where the CAD kernel is not installed, in a sentence; None where it is."""
    if importlib.util.find_spec(_KERNEL) is not None:
        return None
    return f"STEP and IGES need the CAD kernel, which is not installed: run {_command()}"


def require_kernel(path: Path) -> None:
    """Raise ExportError where the kernel for the file at `path` is missing or cannot be loaded."""
    lacking = what_lacks()
    if lacking is not None:
        raise ExportError(f"{path}: {lacking}")
    _Kernel(path)


def write_cad(model: PatchSet, tolerance: float, path: Path, unit: Unit, name: str) -> CadFacts:
    """Write the surface of a model as one face; the format comes from the path's ending.

    .step, .stp: STEP AP214.  .igs, .iges: IGES 5.3.  Coordinates are in `unit`,
    which the header tells.  tolerance: metres, how far the spline may be from the patches.
    name: of the product, of which letters, digits, blanks and - _ . are kept.

    Raises ExportError for another ending, where the kernel is missing, refuses the
    surface or reads back something else, or where the place cannot be written;
    SurfaceError where the tolerance needs too many control points.
    """
    ending = require_ending(path, CAD_ENDINGS, "a CAD surface")
    require_kernel(path)
    spline = one_spline(model, tolerance)
    with _ONE_AT_A_TIME, tempfile.TemporaryDirectory(prefix="georibbon-") as folder:
        kernel = _Kernel(path)
        place = Path(folder) / f"surface{'.step' if ending in _STEP else '.igs'}"
        with kernel.in_words():
            kernel.write(kernel.face(spline), place, unit, plain_name(name))
            read_back = kernel.largest_distance(place, spline)
        if not read_back <= READ_BACK:
            raise ExportError(
                f"{path}: what was read back from it lies {1e3 * read_back:.3g} mm from the "
                "surface, so it was not kept; write .stl, .obj or .ply, and tell us of this"
            )
        write_whole(path, place.read_bytes())
    return CadFacts(spline.deviation, spline.turn, spline.count, spline.smooth, read_back)


def plain_name(name: str) -> str:
    """A name in the letters that both formats have: without accents, others as a dash."""
    letters = unicodedata.normalize("NFKD", name)
    bare = "".join(one for one in letters if not unicodedata.combining(one))
    kept = re.sub(r"[^A-Za-z0-9 ._-]+", "-", bare).strip(" -.")[:LONGEST_NAME].strip()
    return kept or "surface"


def _command() -> str:
    """What installs the kernel: in a working copy by its locked requirements."""
    root = Path(georibbon.__file__).resolve().parents[2]
    if (root / "packaging" / "prepare.sh").is_file():
        return f'"make cad" in {root}'
    return f'{sys.executable} -m pip install "georibbon[cad]"'


class _Kernel:
    """Open CASCADE, loaded and made silent; lengths inside it are millimetres."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._module("Message").Message.DefaultMessenger_s().ChangePrinters().Clear()
        except ModuleNotFoundError as error:
            raise ExportError(
                f"{path}: the CAD kernel is not whole ({error}); install it anew: {_command()}"
            ) from error
        except ImportError as error:
            raise ExportError(
                f"{path}: the CAD kernel cannot be loaded ({error}); install the system's library "
                "that is named there (on Debian and Ubuntu: apt-get install libgl1)"
            ) from error
        for kind in ("STEP", "IGES"):
            controller = getattr(self._module(f"{kind}Control"), f"{kind}Control_Controller")
            controller.Init_s()

    @staticmethod
    def _module(name: str) -> Any:
        """One of its packages; they are thousands of classes without types."""
        return importlib.import_module(f"{_KERNEL}.{name}")

    @contextmanager
    def in_words(self) -> Iterator[None]:
        """What the kernel throws in this block comes as an ExportError.

        Its errors have no class in common; those it has not named are RuntimeErrors.
        """
        try:
            yield
        except Exception as error:
            if type(error).__module__.startswith(_KERNEL) or isinstance(error, RuntimeError):
                raise self._refused(str(error) or type(error).__name__) from error
            raise

    def _refused(self, why: object) -> ExportError:
        return ExportError(
            f"{self._path}: the CAD kernel does not take this surface ({why}); look at the "
            "surface's checks in the report, or write .stl, .obj or .ply"
        )

    def write(self, face: Any, place: Path, unit: Unit, name: str) -> None:
        """Write a face into a file, whose ending tells the format."""
        if place.suffix == ".step":
            self.write_step(face, place, unit, name)
        else:
            self.write_iges(face, place, unit, name)

    def face(self, spline: OneSpline) -> Any:
        """The spline as a face with its natural boundary."""
        surface = self._module("Geom").Geom_BSplineSurface(
            self._poles(_MM * spline.control),
            *(self._reals(_MM * np.unique(knots)) for knots in spline.knots),
            *(self._counts(np.unique(knots, return_counts=True)[1]) for knots in spline.knots),
            DEGREE,
            DEGREE,
        )
        made = self._module("BRepBuilderAPI").BRepBuilderAPI_MakeFace(surface, 1e-6)
        if not made.IsDone():
            raise self._refused(made.Error())
        face = made.Face()
        if not self._module("BRepCheck").BRepCheck_Analyzer(face).IsValid():
            raise self._refused("its face is unsound")
        return face

    def _poles(self, control: FloatArray) -> Any:
        point = self._module("gp").gp_Pnt
        rows, columns = control.shape[:2]
        poles = self._module("collections").Array2_gp_Pnt(1, rows, 1, columns)
        for i, row in enumerate(control.tolist()):
            for j, place in enumerate(row):
                poles.SetValue(i + 1, j + 1, point(*place))
        return poles

    def _reals(self, values: FloatArray) -> Any:
        return self._array("Array1_double", values.tolist())

    def _counts(self, values: Any) -> Any:
        return self._array("Array1_int", values.tolist())

    def _array(self, kind: str, values: list[float]) -> Any:
        array = getattr(self._module("collections"), kind)(1, len(values))
        for i, value in enumerate(values):
            array.SetValue(i + 1, value)
        return array

    def _set(self, **words: str) -> None:
        static = self._module("Interface").Interface_Static
        for key, word in words.items():
            static.SetCVal_s(key.replace("__", "."), word)

    def write_step(self, face: Any, place: Path, unit: Unit, name: str) -> None:
        """Write a face as STEP AP214."""
        control = self._module("STEPControl")
        self._set(write__step__unit=_STEP_UNITS[unit], write__step__schema=_SCHEMA)
        writer = control.STEPControl_Writer()
        writer.SetTolerance(_CLOSE)
        self._require(writer.Transfer(face, control.STEPControl_AsIs))
        model = writer.Model()
        self._name_product(model, name)
        self._head(model, unit, name)
        self._require_written(writer.Write(str(place)), place)

    def _name_product(self, model: Any, name: str) -> None:
        """The product's name, to which the kernel otherwise adds a number that it counts up."""
        product = self._module("StepBasic").StepBasic_Product
        text = self._module("TCollection").TCollection_HAsciiString
        for k in range(1, model.NbEntities() + 1):
            entity = model.Value(k)
            if isinstance(entity, product):
                entity.SetId(text(name))
                entity.SetName(text(name))

    def _head(self, model: Any, unit: Unit, name: str) -> None:
        text = self._module("TCollection").TCollection_HAsciiString
        head = self._module("APIHeaderSection").APIHeaderSection_MakeHeader(model)
        head.SetName(text(name))
        head.SetDescriptionValue(1, text(f"surface through passes; unit: {unit}"))
        head.SetAuthorValue(1, text(""))
        head.SetOrganizationValue(1, text(""))
        head.SetOriginatingSystem(text(f"Georibbon {georibbon.__version__}"))
        head.SetAuthorisation(text(""))

    def write_iges(self, face: Any, place: Path, unit: Unit, name: str) -> None:
        """Write a face as IGES 5.3."""
        text = self._module("TCollection").TCollection_HAsciiString
        writer = self._module("IGESControl").IGESControl_Writer(_IGES_UNITS[unit], 0)
        self._require(writer.AddShape(face))
        writer.ComputeModel()
        model = writer.Model()
        section = model.GlobalSection()
        section.SetAuthorName(text(""))  # the kernel puts the person's login there
        section.SetCompanyName(text(""))
        section.SetSendName(text(name))
        section.SetFileName(text(f"{name}.igs"))
        section.SetSystemId(text(f"Georibbon {georibbon.__version__}"))
        section.SetReceiveName(text(name))
        model.SetGlobalSection(section)
        self._require_written(writer.Write(str(place)), place)

    def _done(self, status: Any) -> bool:
        return status is True or status == self._module("IFSelect").IFSelect_RetDone

    def _require(self, status: Any) -> None:
        if not self._done(status):
            raise self._refused(status)

    def _require_written(self, status: Any, place: Path) -> None:
        if not self._done(status):
            raise ExportError(
                f"{self._path}: the CAD kernel cannot write into the folder for temporary files, "
                f"{place.parent.parent} ({status}); make room there"
            )

    def largest_distance(self, place: Path, spline: OneSpline) -> float:
        """Metres between a file's one face and the spline, at the largest; infinite for another."""
        kind = "STEP" if place.suffix == ".step" else "IGES"
        static = self._module("Interface").Interface_Static
        static.SetIVal_s("read.iges.bspline.continuity", 0)  # or it is cut at its corners
        reader = getattr(self._module(f"{kind}Control"), f"{kind}Control_Reader")()
        self._require(reader.ReadFile(str(place)))
        reader.TransferRoots()
        faces = self._faces(reader.OneShape())
        if len(faces) != 1:
            return float(np.inf)
        found = self._module("BRep").BRep_Tool.Surface_s(faces[0])
        u, w = (_places(knots) for knots in spline.knots)
        worst = 0.0
        for row, at in zip(spline(u, w), _MM * u, strict=True):
            points = (found.Value(at, across) for across in (_MM * w).tolist())
            read = np.array([(one.X(), one.Y(), one.Z()) for one in points]) / _MM
            worst = max(worst, float(np.linalg.norm(read - row, axis=1).max()))
        return worst

    def _faces(self, shape: Any) -> list[Any]:
        kind = self._module("TopAbs").TopAbs_FACE
        explorer = self._module("TopExp").TopExp_Explorer(shape, kind)
        faces = []
        while explorer.More():
            faces.append(self._module("TopoDS").TopoDS.Face(explorer.Current()))
            explorer.Next()
        return faces


def _places(knots: FloatArray) -> FloatArray:
    """Parameters at and between the knots, spread over all where they are many."""
    distinct = np.unique(knots)
    share = np.arange(_LOOKED_AT + 1) / (_LOOKED_AT + 1)
    between = distinct[:-1, None] + np.diff(distinct)[:, None] * share
    every = np.append(between.ravel(), distinct[-1])
    count = min(len(every), _MOST_LOOKED_AT)
    places: FloatArray = every[np.linspace(0, len(every) - 1, count).round().astype(int)]
    return places
