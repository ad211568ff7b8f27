"""What can be done with a virtual ribbon in words: one line a command, one line its answer."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

from georibbon.calibration.plans import AskedPose
from georibbon.errors import SettingsError
from georibbon.session.words import nearest, told
from georibbon.virtual.body import Magnet
from georibbon.virtual.hands import Hands
from georibbon.virtual.settings import check_number

LONGEST = 1000
"""Characters of a command."""
STALL = 3.0
MAGNET, REACH, PASSING = 0.25, 0.12, 4.0
"""A magnet: its share of the field, its reach in metres, the seconds it takes to pass."""
MOST_SECONDS = 86400.0

Run = Callable[[Hands, list[str], float], str]


@dataclass(frozen=True)
class Command:
    """A command: how it is written, what it does, and what carries it out."""

    usage: str
    help: str
    run: Run


def obey(hands: Hands, text: str, now: float) -> str:
    """Carry out one line; the answer, one line.  SettingsError for what cannot be done."""
    if len(text) > LONGEST:
        raise SettingsError(f"a command of {len(text)} characters; give at most {LONGEST}")
    name, _, rest = text.strip().partition(" ")
    if name not in COMMANDS:
        hint = nearest(name, COMMANDS) or "; `help` lists the commands"
        raise SettingsError(f"there is no command {told(name)}{hint}")
    # All but a message's text are words.
    words = [rest.strip()] if name == "message" else rest.split()
    return COMMANDS[name].run(hands, words, now)


def _usage(name: str) -> SettingsError:
    return SettingsError(f"write it as: {COMMANDS[name].usage}")


def _none(name: str, words: list[str]) -> None:
    """Refuse words after a command that takes none."""
    if words:
        raise _usage(name)


def _one(name: str, words: list[str]) -> str:
    if len(words) != 1 or not words[0]:
        raise _usage(name)
    return words[0]


def _number(name: str, word: str, what: str, least: float, most: float) -> float:
    try:
        value = float(word)
    except ValueError:
        raise _usage(name) from None
    return check_number(what, value, least, most)


def _where(hands: Hands, now: float) -> str:
    """Where it is, or is going, and when it lies still."""
    left = hands.body.still_from - now
    if left == inf:
        return f"{hands.place}, in moving hands"
    return f"{hands.place}, still" + (f" in {left:.1f} s" if left > 0 else "")


def _lay(hands: Hands, words: list[str], now: float) -> str:
    hands.lay(_one("lay", words), now)
    return _where(hands, now)


def _moved(name: str, move: Callable[[Hands, float], None]) -> Run:
    """What carries out a command without words that moves it: the answer is where it is."""

    def run(hands: Hands, words: list[str], now: float) -> str:
        _none(name, words)
        move(hands, now)
        return _where(hands, now)

    return run


def _pose(hands: Hands, words: list[str], now: float) -> str:
    word = _one("pose", words)
    if "," in word:
        hands.pose_as(_asked(word), now)
    else:
        try:
            number = int(word)
        except ValueError:
            raise _usage("pose") from None
        hands.pose(number, now)
    return _where(hands, now)


def _asked(word: str) -> AskedPose:
    parts = word.split(",")
    table = parts[-1] == "table"
    try:
        roll, heading, pitch = map(float, parts[:-1] if table else parts)
    except ValueError:
        raise _usage("pose") from None
    return roll, heading, pitch, table


def _poses(hands: Hands, words: list[str], now: float) -> str:
    _none("poses", words)
    count = len(hands.places.poses)
    hands.play(range(1, count + 1), now)
    return f"{count} poses, one after another"


def _play(hands: Hands, words: list[str], now: float) -> str:
    _none("play", words)
    poses, passes = len(hands.places.poses), hands.places.names
    hands.play([*range(1, poses + 1), *passes], now)
    return f"{poses} poses, then {', '.join(passes)}"


def _share(name: str, told_as: str) -> Run:
    """What sets a fault of the cable that is a share of the frames: `Cable` calls it so, too."""

    def run(hands: Hands, words: list[str], _now: float) -> str:
        share = _number(name, _one(name, words), "the share", 0.0, 1.0)
        setattr(hands.wire.cable, name, share)
        return f"{share:g} of the frames are {told_as} on the cable"

    return run


def _stall(hands: Hands, words: list[str], now: float) -> str:
    seconds = STALL
    if words:
        seconds = _number("stall", _one("stall", words), "seconds", 0.0, MOST_SECONDS)
    hands.wire.stall(now + seconds)
    return f"stalled for {seconds:g} s"


def _unplug(hands: Hands, words: list[str], now: float) -> str:
    seconds = inf
    if words:
        seconds = _number("unplug", _one("unplug", words), "seconds", 0.0, MOST_SECONDS)
    hands.unplug(now + seconds)
    return "unplugged, until replug" if seconds == inf else f"unplugged for {seconds:g} s"


def _replug(hands: Hands, words: list[str], _now: float) -> str:
    _none("replug", words)
    if hands.plugged:
        raise SettingsError("the cable is in already; unplug first")
    hands.plug()
    return "plugged in; silent until the host says start"


def _baud(hands: Hands, words: list[str], _now: float) -> str:
    word = _one("baud", words)
    if word not in ("wrong", "right"):
        raise _usage("baud")
    hands.wire.cable.garbled = word == "wrong"
    return f"the host listens at the {word} baud rate"


def _identity(hands: Hands, words: list[str], _now: float) -> str:
    name = _one("identity", words)
    if not name.isprintable() or len(name) > 60:
        raise SettingsError(f"{told(name)} is no ribbon's name; give at most 60 printable signs")
    identity = hands.wire.identity
    hands.wire.identity = replace(identity, ribbon=replace(identity.ribbon, id=name))
    return f"answers as {name}"


def _magnet(hands: Hands, words: list[str], now: float) -> str:
    if not 1 <= len(words) <= 3:
        raise _usage("magnet")
    if words[0] == "off":
        _none("magnet", words[1:])
        hands.body.put(None)
        return "no magnet"
    length = hands.wire.identity.ribbon.length
    if words[0] == "pass":
        return _passing_magnet(hands, words[1:], length, now)
    return _lying_magnet(hands, words, length)


def _lying_magnet(hands: Hands, words: list[str], length: float) -> str:
    share = _magnet_share(words[0])
    place, reach = length / 2, REACH
    if len(words) > 1:
        place = _number("magnet", words[1], "the place (m)", 0.0, length)
    if len(words) > 2:
        reach = _number("magnet", words[2], "the reach (m)", 0.01, 10.0)
    hands.body.put(Magnet(share, place, reach))
    return f"a magnet of {share:g} of the field at {place:g} m, reaching {reach:g} m"


def _passing_magnet(hands: Hands, words: list[str], length: float, now: float) -> str:
    share, seconds = MAGNET, PASSING
    if words:
        share = _magnet_share(words[0])
    if len(words) > 1:
        seconds = _number("magnet", words[1], "seconds", 0.1, MOST_SECONDS)
    way = length + 4 * REACH
    hands.body.put(Magnet(share, -2 * REACH, REACH, now, way / seconds, now + seconds))
    return f"a magnet of {share:g} of the field passes within {seconds:g} s"


def _magnet_share(word: str) -> float:
    return _number("magnet", word, "the share of the field", 0.0, 10.0)


def _dead(hands: Hands, words: list[str], _now: float) -> str:
    name = _sensor(hands, _one("dead", words))
    hands.body.dead.add(name)
    return f"{name} says nothing but 0"


def _alive(hands: Hands, words: list[str], _now: float) -> str:
    name = _sensor(hands, _one("alive", words))
    hands.body.dead.discard(name)
    return f"{name} is alive"


def _sensor(hands: Hands, name: str) -> str:
    known = [sensor.name for sensor in hands.wire.identity.ribbon.sensors]
    if name not in known:
        hint = nearest(name, known) or f"; the sensors are A01, M01 to {known[-1]}"
        raise SettingsError(f"there is no sensor {told(name)}{hint}")
    return name


def _noise(hands: Hands, words: list[str], _now: float) -> str:
    factor = _number("noise", _one("noise", words), "the factor", 0.0, 1000.0)
    hands.body.noise = factor
    return f"{factor:g} times the sensors' own noise"


def _message(hands: Hands, words: list[str], _now: float) -> str:
    text = _one("message", words)
    if not text.isprintable():
        raise SettingsError(f"{told(text)} cannot be said in a line; give printable signs")
    hands.wire.message(text)
    return f"said: {text}"


def _status(hands: Hands, words: list[str], now: float) -> str:
    _none("status", words)
    wire = hands.wire
    rate = f"{wire.rate:g} frames a second"
    cable = "the cable is out" if not hands.plugged else rate if wire.streaming else "silent"
    left = f", {hands.steps_left} places to go" if hands.steps_left else ""
    sent = wire.sent
    lost = sent.packets - sent.whole
    numbers = f"{sent.packets} packets, {sent.frames} of frames, {lost} lost or damaged"
    return f"{_where(hands, now)}{left}; {cable}; {numbers}"


def _help(_hands: Hands, words: list[str], _now: float) -> str:
    if not words:
        return "commands: " + "; ".join(command.usage for command in COMMANDS.values())
    name = _one("help", words)
    if name not in COMMANDS:
        raise SettingsError(f"there is no command {told(name)}; `help` lists the commands")
    return f"{COMMANDS[name].usage}: {COMMANDS[name].help}"


def _quit(hands: Hands, words: list[str], _now: float) -> str:
    _none("quit", words)
    hands.ended.set()
    return "bye"


COMMANDS: dict[str, Command] = {
    "lay": Command("lay NAME", "lay it on a pass or tie, such as P2 or T1", _lay),
    "next": Command("next", "lay it on the next pass or tie", _moved("next", Hands.lay_next)),
    "lift": Command("lift", "take it up into the hands, which move", _moved("lift", Hands.lift)),
    "hold": Command("hold", "keep it still as it is", _moved("hold", Hands.hold)),
    "pose": Command(
        "pose N | pose ROLL,HEADING,PITCH[,table]",
        "put it into a pose of the plan, or into any, in degrees",
        _pose,
    ),
    "poses": Command("poses", "all poses of the plan, each held for a while", _poses),
    "play": Command("play", "all poses, then all passes and ties, each held for a while", _play),
    "drop": Command(
        "drop SHARE", "so many of the frames are lost on the cable, 0 to 1", _share("drop", "lost")
    ),
    "damage": Command(
        "damage SHARE", "so many of the frames are damaged, 0 to 1", _share("damage", "damaged")
    ),
    "stall": Command("stall [SECONDS]", f"it hangs for a while ({STALL:g} s)", _stall),
    "unplug": Command("unplug [SECONDS]", "the cable is pulled, for a while or for good", _unplug),
    "replug": Command("replug", "the cable is put back", _replug),
    "baud": Command("baud wrong | baud right", "the host listens at the wrong baud rate", _baud),
    "identity": Command("identity ID", "it answers as another ribbon", _identity),
    "magnet": Command(
        "magnet SHARE [PLACE [REACH]] | magnet pass [SHARE [SECONDS]] | magnet off",
        f"a magnet, of the field's strength, at a place (m, the middle) and reaching {REACH:g} m; "
        f"or one passing along it ({MAGNET:g} of the field, {PASSING:g} s); or none",
        _magnet,
    ),
    "dead": Command("dead SENSOR", "the sensor says nothing but 0", _dead),
    "alive": Command("alive SENSOR", "the sensor works again", _alive),
    "noise": Command("noise FACTOR", "times the sensors' own noise", _noise),
    "message": Command("message TEXT", "the ribbon says this to the person", _message),
    "status": Command("status", "where it is and what it has sent", _status),
    "help": Command("help [COMMAND]", "the commands, or what one does", _help),
    "quit": Command("quit", "end", _quit),
}
