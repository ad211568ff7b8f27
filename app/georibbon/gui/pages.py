"""The pages in the middle of the window, and the bar on the left that leads to them."""

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QStackedWidget, QToolBar, QWidget

Make = Callable[[], QWidget]


@dataclass(frozen=True)
class Page:
    """One page: the action that leads to it, and how it is made when it is first shown."""

    id: str
    make: Make


class Pages(QStackedWidget):
    """The pages, each made when it is first shown.

    A page may have `entered()` and `left()`, called when it comes into sight and
    when it goes out of it.  turned(id): another page is shown.
    """

    turned = Signal(str)

    def __init__(self, pages: tuple[Page, ...], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._make = {page.id: page.make for page in pages}
        self._made: dict[str, QWidget] = {}
        self.current = ""

    def made(self, name: str) -> QWidget | None:
        """A page, where it was shown already."""
        return self._made.get(name)

    def page(self, name: str) -> QWidget:
        """A page, made where it was not."""
        if name not in self._made:
            self._made[name] = self._make[name]()
            self.addWidget(self._made[name])
        return self._made[name]

    def show_page(self, name: str) -> None:
        """Show a page; nothing where it is shown already."""
        if name == self.current:
            return
        before = self._made.get(self.current)
        _call(before, "left")
        page = self.page(name)
        self.current = name
        self.setCurrentWidget(page)
        self._tell_size()
        _call(page, "entered")
        self.turned.emit(name)

    def _tell_size(self) -> None:
        """Have all around know at once what this page needs, before panels are put beside it."""
        around: QWidget | None = self
        while around is not None:
            around.updateGeometry()
            around = around.parentWidget()

    def sizeHint(self) -> QSize:
        """As the page that is shown wants it, not the widest of all."""
        page = self.currentWidget()
        return super().sizeHint() if page is None else page.sizeHint()

    def minimumSizeHint(self) -> QSize:
        """As the page that is shown needs it, not the widest of all."""
        page = self.currentWidget()
        return super().minimumSizeHint() if page is None else least_size(page)

    def end(self) -> None:
        """The window closes: what a page has running ends."""
        for page in self._made.values():
            _call(page, "end")


def least_size(widget: QWidget) -> QSize:
    """What a widget cannot be made smaller than."""
    return widget.minimumSizeHint().expandedTo(widget.minimumSize())


def _call(page: QWidget | None, name: str) -> None:
    method = getattr(page, name, None)
    if method is not None:
        method()


class NavigationBar(QToolBar):
    """The pages' actions, one under the other, the present one marked."""

    def __init__(self, actions: dict[str, QAction], parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("navigation")
        self.setOrientation(Qt.Orientation.Vertical)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setIconSize(QSize(28, 28))
        self.setMovable(False)
        self._actions = actions
        group = QActionGroup(self)
        for action in actions.values():
            group.addAction(action)
            self.addAction(action)
            self.widgetForAction(action).setMinimumWidth(84)

    def mark(self, name: str) -> None:
        """Mark the page that is shown."""
        self._actions[name].setChecked(True)
