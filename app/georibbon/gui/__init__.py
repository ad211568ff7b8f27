"""The window, on Qt.  Nothing outside this room knows Qt but the command line, which opens it.

Where to look:

    app            the application is made, and the window shown
    window         the assembly: it makes the parts and connects them
    actions        every action, in one table; menus, toolbar, keys and palette come from it
    pages, docks   the pages in the middle and the bar that leads to them; the panels around
    parts          what every page and panel is given
    document       what is open, its settings with their undo, its reconstruction
    station/       the ribbon that is connected, real or virtual
    capture_desk   the capture that goes on: its engine in a thread of its own
    connect/       the page Connect: ports, the virtual ribbon, every axis live
    calibrating/   the page Calibrate: the poses, the daily check, what is kept
    capturing/     the page Capture: the plan, pass after pass, the survey
    scene_*, view_panel, measure_*          the 3D view and what is chosen and measured in it
    passes_panel, pass_*, smoothing, surface_panel      what is chosen of passes and surface
    curve_*, result_views, notices_panel, checks_panel      the curves and words of a result
    review/        history and notes, comparing, exporting
    help/          the manual's window
    language, units, theme, style, icons, verdict_icon, settings    how it speaks, measures,
                   looks, remembers
    notifier, log, crash, display           what is told, and what happens when something fails

Pages and panels read the document, the station and the capture, and never each other.
State machines and computations live outside this room and are tested without a window.
"""
