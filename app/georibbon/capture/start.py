"""Where a capture begins: a new session with its plan, or one to go on with."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

from georibbon.capture.plan import DEFAULT_POSES, CapturePlan, PlannedLayout, check_survey
from georibbon.device.identity import Identity, check_same
from georibbon.errors import DeviceError, SessionError, SettingsError
from georibbon.ribbon import Ribbon
from georibbon.session.files import kind_of
from georibbon.session.outline import ribbon_table, survey_tables
from georibbon.session.session import Session
from georibbon.session.state import SessionPlan, SessionState


def open_capture(
    path: Path,
    identity: Identity,
    plan: CapturePlan | None = None,
    counts: Mapping[str, int] | None = None,
) -> tuple[Session, CapturePlan]:
    """The session at a path, new or to go on with, and what is planned in it.

    plan: None for the session's own, or the usual one where it is new.  counts:
    of poses, passes or ties, in place of the plan's.  Raises SessionError where
    the session is of another ribbon or can only be read, and SettingsError where
    the plan cannot be meant on this ribbon.
    """
    if kind_of(path) == "nothing":
        usual = CapturePlan() if plan is None else plan
        return _new(path, identity, usual.with_counts(counts or {}))
    session = Session.open(path)
    try:
        return session, go_on(session, identity, plan, counts)
    except BaseException:
        session.close()
        raise


def _new(path: Path, identity: Identity, plan: CapturePlan) -> tuple[Session, CapturePlan]:
    check_plan(plan, identity.ribbon)
    session = Session.create(path, title=plan.title)
    try:
        write_ribbon(session, identity.ribbon, identity.firmware)
        write_plan(session, plan)
    except BaseException:
        session.close()
        raise
    return session, plan


def go_on(
    session: Session,
    identity: Identity,
    plan: CapturePlan | None = None,
    counts: Mapping[str, int] | None = None,
) -> CapturePlan:
    """What is planned in a session that is open, to go on with; raises as `open_capture`."""
    if session.read_only:
        why = "; ".join(session.warnings) or "it can only be read"
        raise SessionError(f"{session.path}: the capture cannot go on: {why}")
    try:
        check_same(identity.ribbon, session.state.ribbon)
    except DeviceError as error:
        raise SessionError(f"{session.path}: {error}") from error
    plan = (_planned(session.state) if plan is None else plan).with_counts(counts or {})
    check_plan(plan, identity.ribbon)
    # Its rate may have changed since; and without any copy of this no frame can be salvaged.
    write_ribbon(session, identity.ribbon, identity.firmware)
    write_plan(session, plan)
    return plan


def _planned(state: SessionState) -> CapturePlan:
    """What the session says is planned; nothing more where it was not captured by a plan."""
    if state.plan is None:
        return CapturePlan(poses=0 if state.poses else DEFAULT_POSES, passes=0)
    of = state.plan
    layout = planned_layout(of)
    return CapturePlan(of.poses, of.passes, of.ties, title=state.title, layout=layout)


def planned_layout(plan: SessionPlan) -> PlannedLayout:
    """How a session says its passes are meant to be laid; as usual where that cannot be meant."""
    try:
        return PlannedLayout(**cast("dict[str, Any]", dict(plan.layout)))
    except SettingsError:
        return PlannedLayout()


def kept_plan(plan: CapturePlan) -> SessionPlan:
    """What a session keeps of a plan."""
    usual = plan.layout == PlannedLayout()
    return SessionPlan(plan.poses, plan.passes, plan.ties, {} if usual else asdict(plan.layout))


def check_plan(plan: CapturePlan, ribbon: Ribbon) -> None:
    """Raise SettingsError where the plan cannot be meant on this ribbon."""
    names = [one.name for one in plan.planned_passes]
    check_survey(plan.survey or {}, ribbon, names, plan.source)


def write_ribbon(session: Session, ribbon: Ribbon, firmware: str | None) -> None:
    """Write which ribbon it is; the more copies, the surer that frames can be salvaged."""
    told = {} if firmware is None else {"firmware": firmware}
    session.do("ribbon", **ribbon_table(ribbon), **told)


def write_plan(session: Session, plan: CapturePlan) -> None:
    """Write what the plan says and the session does not say yet; nothing of the session is lost."""
    state = session.state
    piece = plan.workpiece
    if piece is not None and piece != state.workpiece:
        known = {} if piece.heading is None else {"heading": piece.heading}
        session.do("workpiece", level=piece.level, **known)
    if plan.survey is not None:
        tables = survey_tables(state.marks, state.distances, state.crossings)
        both = {key: _joined(tables[key], plan.survey.get(key, [])) for key in tables}
        if both != tables:
            session.do("survey", **both)
    kept = kept_plan(plan)
    if state.plan != kept:  # the last: undoing ends at the first of these
        layout = {"layout": kept.layout} if kept.layout else {}
        session.do("plan", poses=kept.poses, passes=kept.passes, ties=kept.ties, **layout)


def _joined(there: list[dict[str, object]], planned: object) -> list[object]:
    """What the session's survey has, and what of the plan's it has not."""
    return [*there, *(entry for entry in cast("list[object]", planned) if entry not in there)]
