"""What a printed number stands for: an interval, with the rounding of the print."""

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from typing import Self

_ASCII = str.maketrans({"\u2212": "-", "\u2013": "-", "\u2014": "-", "\u2026": "...", "\u03c0": "pi"})
_SPACES = "[ \u00a0\u2009\u202f]"  # plain, no-break, thin, narrow no-break: all four separate thousands in print
_DECIMAL = (
    rf"[+-]?{_SPACES}?(?:\d{{1,3}}(?:{_SPACES}\d{{3}})+|\d+)(?:[.,]\d+)?"
    rf"(?:[eE][+-]?\d+|{_SPACES}?[*x\u00b7\u00d7]{_SPACES}?10\^\{{?[+-]?\d+\}}?)?"
)
_EXACT = r"[+-]?(?:\d*pi(?:/\d+)?|\d+/\d+)"
_NUMBER = rf"(?:{_EXACT}|{_DECIMAL})"
_BOUND = re.compile(rf"(<=|>=|<|>|\u2264|\u2265)\s*({_NUMBER})")
_RANGE = re.compile(rf"({_NUMBER})\s*(?:\.{{2,3}}|-|to)\s*({_NUMBER})")
_ULPS = 1e-12  # an exact print (3/4, pi/2) is met to floating-point rounding, not to the last bit


@dataclass(frozen=True, kw_only=True)
class Printed:
    """The values that a printed number, bound or range stands for.

    Attributes
    ----------
    low, high : float
        Ends of the print; equal for a number, one of them infinite for a bound.
    rounding : float
        Half a unit of the last printed digit; zero for bounds and exact prints.
    strict : bool
        True for ``<`` and ``>``, whose end itself does not agree.

    Examples
    --------
    >>> Printed.parse("0,214")
    Printed(low=0.214, high=0.214, rounding=0.0005, strict=False)
    >>> Printed.parse("<0.1").contains(0.0999), Printed.parse("<0.1").contains(0.1)
    (True, False)
    """

    low: float
    high: float
    rounding: float = 0.0
    strict: bool = False

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a number, bound or range as printed; ``ValueError`` if the text is none of these."""
        plain = text.strip().translate(_ASCII)
        if re.fullmatch(_NUMBER, plain):
            value, rounding = _number(plain)
            return cls(low=value, high=value, rounding=rounding)
        if found := _BOUND.fullmatch(plain):
            sign, end = found[1], _number(found[2])[0]
            low, high = (-math.inf, end) if sign in ("<", "<=", "\u2264") else (end, math.inf)
            return cls(low=low, high=high, strict=sign in ("<", ">"))
        if found := _RANGE.fullmatch(plain):
            (low, fine), (high, coarse) = _number(found[1]), _number(found[2])
            if low > high:
                raise ValueError(f"the range {text!r} runs downwards")
            return cls(low=low, high=high, rounding=max(fine, coarse))
        raise ValueError(f"{text!r} is not a number, a bound (<x, <=x, >x, >=x) or a range (a..b)")

    def reach(self, tolerance: str = "") -> float:
        """Distance outside the print that still agrees: its rounding, or `tolerance` (``0.01`` or ``5%``) instead."""
        if not tolerance:
            return self.rounding
        if tolerance.endswith("%"):
            return float(tolerance[:-1]) / 100 * max(abs(end) for end in (self.low, self.high) if math.isfinite(end))
        return float(tolerance)

    def contains(self, value: float, tolerance: str = "") -> bool:
        """Whether `value` agrees with the print."""
        reach = self.reach(tolerance)
        if self.strict and reach == 0:
            return self.low < value < self.high
        # A value exactly half a unit away agrees, although 0.2145 - 0.214 exceeds 0.0005 in binary.
        slack = reach * 1e-9 + _ULPS * max(abs(end) for end in (self.low, self.high) if math.isfinite(end))
        return self.low - reach - slack <= value <= self.high + reach + slack


def _number(text: str) -> tuple[float, float]:
    """Value of one printed number and half a unit of its last digit (zero for fractions and multiples of pi)."""
    if "pi" in text or "/" in text:
        over, _, under = text.partition("/")
        factor = {"": "1", "-": "-1", "+": "1"}.get(count := over.replace("pi", ""), count)
        return float(factor) * (math.pi if "pi" in over else 1.0) / float(under or 1), 0.0
    text = re.sub(rf"{_SPACES}?[*x\u00b7\u00d7]{_SPACES}?10\^\{{?([+-]?\d+)\}}?$", r"e\1", text)
    number = Decimal(re.sub(_SPACES, "", text).replace(",", "."))
    return float(number), float(Decimal("0.5").scaleb(int(number.as_tuple().exponent)))
