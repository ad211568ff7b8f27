"""What the capture page says: what to lay and how, what to correct, how it went."""

import math

from georibbon.capture.beside import Beside, Hint
from georibbon.capture.plan import tie_places
from georibbon.gui.capturing.model import CaptureModel
from georibbon.gui.language import N_, sentence, tr
from georibbon.gui.units import Units

STATUS = {"open": N_("open"), "taken": N_("taken"), "skipped": N_("left out")}
VERDICT = {"good": N_("good"), "acceptable": N_("acceptable"), "redo": N_("redo")}
KIND = {"pose": N_("pose"), "pass": N_("pass"), "tie": N_("tie")}
WHERE = {
    "start": N_("at the start"),
    "middle": N_("in the middle"),
    "end": N_("at the end"),
    "all": N_("all along"),
}


def headline(item) -> str:
    """What is asked for, in two or three words."""
    if item is None:
        return tr("Everything planned is taken")
    if item.is_pose:
        return tr("Hold {key}", key=item.key)
    again = item.status == "taken"
    return tr("Lay {name} again", name=item.key) if again else tr("Lay {name}", name=item.key)


def instruction(model: CaptureModel, item, units: Units, length: float) -> str:
    """How to lay what is asked for."""
    if item is None:
        return tr("Enter the survey, lay further passes, or finish the capture.")
    if item.is_pose:
        return sentence(item.words)
    if item.what.kind == "tie":
        return _tie(model, item.key, units, length)
    order = model.pass_order
    place = order.index(item.key) if item.key in order else len(order)
    if place == 0:
        return tr("along the edge where you begin; all other passes go to its left")
    return tr(
        "{distance} to the left of {neighbour}, its start at the same edge, running the same way",
        distance=units.text(model.layout.spacing),
        neighbour=order[place - 1],
    )


def _tie(model: CaptureModel, name: str, units: Units, length: float) -> str:
    kinds = model.kinds
    ties = [one for one in model.order if kinds.get(one) == "tie"]
    if name not in ties:
        return tr("across the passes")
    at = tie_places(len(ties))[ties.index(name)] * length
    return tr(
        "across all passes, about {distance} from their starts, beginning at the first pass; its "
        "middle on the middle pass",
        distance=units.text(at),
    )


def hint_words(hint: Hint, beside: Beside, units: Units) -> str:
    """What to correct, in one sentence."""
    where = tr(WHERE[hint.where])
    if hint.kind == "crosses":
        at = units.text(hint.amount)
        return tr("It crosses {name} at {at}: lay it beside it", name=beside.neighbour, at=at)
    if hint.kind == "turn-left":
        return tr("Turn the end {angle}° to the left", angle=f"{math.degrees(hint.amount):.0f}")
    if hint.kind == "turn-right":
        return tr("Turn the end {angle}° to the right", angle=f"{math.degrees(hint.amount):.0f}")
    amount = units.text(hint.amount)
    if hint.kind == "near":
        return tr("{amount} too near {where}", amount=amount, where=where)
    return tr("{amount} too far {where}", amount=amount, where=where)


def beside_words(beside: Beside, units: Units) -> tuple[str, str]:
    """How parallel, and how far, in one line each."""
    angle = tr(
        "{angle}° off parallel to {name}, {worst}° at worst ({at} along)",
        angle=f"{math.degrees(beside.angle_rms):.1f}",
        name=beside.neighbour,
        worst=f"{abs(math.degrees(beside.angle_worst)):.1f}",
        at=units.text(beside.angle_at),
    )
    far = tr(
        "{mean} apart, from {least} ({least_at} along) to {most} ({most_at} along)",
        mean=units.text(beside.mean),
        least=units.text(beside.least),
        least_at=units.text(beside.least_at),
        most=units.text(beside.most),
        most_at=units.text(beside.most_at),
    )
    return angle, far


def restless_words(live) -> str:
    """Stillness and magnetic disturbance, in a line; live: the engine's `Live`."""
    stillness, curve = live.stillness, live.curve
    if stillness is None:
        return tr("no frame has come yet")
    words = sentence(stillness.reason)
    if curve is not None and curve.disturbed:
        names = ", ".join(one.sensor for one in curve.disturbed[:6])
        more = len(curve.disturbed) - 6
        if more > 0:
            names = tr("{names} and {n} more", names=names, n=more)
        words = tr("{words}; disturbed: {names}", words=words, names=names)
    return words
