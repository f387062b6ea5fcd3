"""Numbers with units as they are typed: 0.5mm, 3000rpm, 2pi, pi/2.

Only the command line and fields of the live page have units other than SI.
"""

import math
import re
from contextlib import suppress
from fractions import Fraction

from flexmb.checks import did_you_mean
from flexmb.errors import InputError

Scale = tuple[Fraction, int]  # factor to SI, a fraction and a power of pi; by exact fractions 0.3mm is the double 3e-4
# Quantity, for messages, and typed units with their factors, by SI unit of the parameter; "_" is a blank in a unit.
KINDS = {
    "m": ("a length", "m=1 cm=1e-2 mm=1e-3 um=1e-6 μm=1e-6 nm=1e-9"),
    "s": ("a time", "s=1 ms=1e-3 us=1e-6 μs=1e-6 ns=1e-9 min=60"),
    "kg": ("a mass", "kg=1 g=1e-3 t=1000"),
    "N": ("a force", "N=1 mN=1e-3 kN=1e3"),
    "Pa": ("a stress", "Pa=1 kPa=1e3 MPa=1e6 GPa=1e9"),
    "rad": ("an angle", "rad=1 mrad=1/1000 deg=1/180*pi"),
    "rad/s": ("an angular speed", "rad/s=1 rpm=1/30*pi deg/s=1/180*pi"),
    "m/s": ("a speed", "m/s=1 mm/s=1/1000"),
    "m/s^2": ("an acceleration", "m/s^2=1"),
    "N m": ("a moment", "N_m=1 kN_m=1000"),
    "kg m^2": ("a moment of inertia", "kg_m^2=1"),
    "kg/m^3": ("a density", "kg/m^3=1"),
    "N/m": ("", "N/m=1 kN/m=1000"),
    "N s/m": ("", "N_s/m=1"),
    "N m/rad": ("", "N_m/rad=1"),
    "s/m": ("", "s/m=1"),
    "Hz": ("", "Hz=1 kHz=1000"),
    "": ("a number without unit", ""),
}

NOUNS = {unit: quantity for unit, (quantity, _) in KINDS.items() if quantity}  # quantity of an SI unit, for messages


def _scales(text: str) -> dict[str, Scale]:
    pairs = (entry.split("=") for entry in text.split())
    return {unit.replace("_", " "): (Fraction(f.removesuffix("*pi")), int(f.endswith("*pi"))) for unit, f in pairs}


# Typed units by SI unit of the parameter; "": a parameter without a unit.
UNITS = {unit: _scales(text) for unit, (_, text) in KINDS.items()}
EXAMPLES = {"m": "0.5mm", "s": "0.1s", "kg": "200g", "rad/s": "2pi", "rad": "30deg"}
WITH_PI = ("rad", "rad/s", "")  # SI units of the parameters that may be multiples of pi: 2pi, 2pi rad/s
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
TEXT = re.compile(rf"(?P<sign>[+-]?)(?:(?P<number>{NUMBER})\s*(?P<times>\*?)\s*)?(?P<pi>pi(?![A-Za-z]))?(?P<rest>.*)")
DIVISOR = re.compile(rf"\s*/\s*({NUMBER})(.*)")


def known_unit(text: str) -> str | None:
    """SI unit in `UNITS` of a `text` ("kg m2": "kg m^2"); None for an unknown unit."""
    return {_bare(unit): unit for unit in UNITS}.get(_bare(text))


def known_units(declared: str) -> str:
    """Units of `UNITS` in a declared unit such as "rad or m"; "" for none."""
    return " or ".join(filter(None, map(known_unit, declared.split(" or "))))


def noun(unit: str) -> str:
    """Quantity and unit of a parameter in SI, for messages: "a length in m"."""
    return f"{NOUNS.get(unit, 'a number')} in {unit}" if unit else NOUNS[""]


def quantity(text: str, unit: str, name: str) -> float:
    """Number of a typed text ("0.5mm", "2pi", "1.5*pi", "pi/2", "3000rpm", "-5deg") in a unit of `UNITS` or "rad or m".

    Examples
    --------
    >>> quantity("0.5mm", "m", "--clearance")
    0.0005
    >>> quantity("3000rpm", "rad/s", "--speed")
    314.1592653589793
    """
    if " or " in unit:
        for one in unit.split(" or "):
            with suppress(InputError):
                return quantity(text, one, name)
        raise InputError(f"{name}: {text!r} is no number in {unit}.")
    match = TEXT.fullmatch(text.strip())
    if match is None or not (match["number"] or match["pi"]) or (match["times"] and not match["pi"]):
        # "--clearance 0.5mm", "--set B.clearance=0.5mm", "--method hht:0.05"; of a part of a value the number alone
        flag = "" if ": " in name else name if name.endswith(":") else f"{name}=" if " " in name else f"{name} "
        example = f"{flag}{EXAMPLES.get(unit, '1.5')}"
        raise InputError(f"{name}: {text!r} is no number; give {noun(unit)}, e.g. {example}.")
    value, rest = _fraction(match["number"] or "1", text, name), match["rest"]
    if match["pi"] and (division := DIVISOR.fullmatch(rest)):
        divisor, rest = _fraction(division[1], text, name), division[2]
        if divisor == 0:
            raise InputError(f"{name}: {text!r} divides by zero.")
        value /= divisor
    scale, power = _scale(rest.strip(), unit, text, name, pi=bool(match["pi"]))
    value *= -scale if match["sign"] == "-" else scale
    return float(value) * math.pi**power


def _fraction(number: str, text: str, name: str) -> Fraction:
    """Exact value of a written number; huge exponents are refused."""
    if not abs(float(number)) < 1e200:
        raise InputError(f"{name}: {text!r} is too large.")
    return Fraction(number) if float(number) > 1e-200 else Fraction(0)


def _scale(unit_text: str, unit: str, text: str, name: str, *, pi: bool) -> Scale:
    """Factor from the typed unit to SI."""
    allowed = UNITS[unit]
    if pi and (unit not in WITH_PI or (unit_text and _bare(unit_text) != _bare(unit))):
        where = f"give 2pi or 2pi {unit}"
        if unit not in WITH_PI:
            where = f"it needs {noun(unit)}, e.g. {EXAMPLES.get(unit, '1.5')}"
        raise InputError(f"{name}: {text!r}: pi goes with angles and angular speeds in rad and rad/s only; {where}.")
    if not unit_text:
        return Fraction(1), int(pi)
    same = {_bare(typed): scale for typed, scale in allowed.items()}
    if _bare(unit_text) in same:
        factor, power = same[_bare(unit_text)]
        return factor, power + int(pi)
    kind = next((u for u, units in UNITS.items() if _bare(unit_text) in {_bare(typed) for typed in units}), None)
    if kind is not None:
        how = "" if unit else f", or declare the unit in the file: Annotated[float, {kind!r}]"
        raise InputError(f"{name}: {text!r} is {NOUNS.get(kind, f'in {kind}')}; give {noun(unit)}{how}.")
    if not allowed:
        raise InputError(f"{name}: {text!r}: {unit_text!r} is no unit known here; {name} is {noun(unit)}.")
    raise InputError(f"{name}: {text!r}: {unit_text!r} is no unit known here. {did_you_mean(unit_text, allowed)}")


def _bare(unit: str) -> str:
    """A unit without blanks, dots and the sign of a power."""
    return re.sub(r"[\s.*^]", "", unit).replace("μ", "µ")
