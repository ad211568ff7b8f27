"""What was picked and measured in the 3D view, in words and numbers that can be copied."""

from __future__ import annotations

from typing import TYPE_CHECKING

from georibbon.gui.language import N_, tr
from georibbon.gui.units import Units

if TYPE_CHECKING:
    from georibbon.scene.measuring import Distance, Pick, Section


def pick_words(pick: Pick, units: Units) -> list[str]:
    """A picked place, one line a fact."""
    lines = [_position(pick, units)]
    if pick.sigma is not None:
        lines.append(tr("uncertainty (1σ) {sigma}", sigma=units.text(pick.sigma, 1)))
    near = tr("{name} at {s}", name=pick.pass_name, s=units.text(pick.s))
    if pick.away > 0.0:
        near = tr("{near}, {away} away", near=near, away=units.text(pick.away))
    lines.append(tr("nearest pass: {near}", near=near))
    bends = (
        (N_("curvature along the passes {value} 1/m"), pick.along),
        (N_("mean curvature {value} 1/m"), pick.mean),
        (N_("Gaussian curvature {value} 1/m²"), pick.gaussian),
    )
    lines += [tr(words, value=f"{bend:.3g}") for words, bend in bends if bend is not None]
    x, y, z = pick.normal
    lines.append(tr("normal {x:.3f}, {y:.3f}, {z:.3f}", x=x, y=y, z=z))
    return lines


def distance_words(distance: Distance, units: Units) -> list[str]:
    """A distance, one line a fact."""
    straight = units.text(distance.straight, 1)
    if distance.sigma is not None:
        sigma = units.text(distance.sigma, 1)
        straight = tr(
            "{length} ± {sigma} (1σ, ends taken as independent)", length=straight, sigma=sigma
        )
    lines = [tr("straight {length}", length=straight)]
    if distance.along is not None:
        lines.append(tr("along the surface {length}", length=units.text(distance.along, 1)))
    x, y, z = (units.number(v) for v in distance.second.position - distance.first.position)
    lines.append(tr("in x {x}, in y {y}, in z {z} {unit}", x=x, y=y, z=z, unit=units.symbol))
    return [*lines, *_ends(distance, units)]


def section_words(section: Section, units: Units) -> list[str]:
    """A section, one line a fact."""
    kind = tr("upright") if section.upright else tr("along the line of sight")
    lines = [tr("{kind}, {length} long in all", kind=kind, length=units.text(section.length, 1))]
    if section.between is not None:
        lines.append(tr("between the places {length}", length=units.text(section.between, 1)))
    low, high = float(section.height.min()), float(section.height.max())
    lines.append(tr("height from {low} to {high}", low=units.number(low), high=units.text(high)))
    return [*lines, *_ends(section, units)]


def _ends(of: Distance | Section, units: Units) -> list[str]:
    return [
        tr("from {place}", place=_position(of.first, units)),
        tr("to {place}", place=_position(of.second, units)),
    ]


def _position(pick: Pick, units: Units) -> str:
    x, y, z = (units.number(float(value), 1) for value in pick.position)
    return f"x {x}, y {y}, z {z} {units.symbol}"
