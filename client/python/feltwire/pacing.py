"""The pace of a program's own loop."""
from __future__ import annotations

import time as clock
from typing import Callable, Iterator, Optional


def require_rate(rate: float) -> None:
    if not rate > 0.0:
        raise ValueError(f"rate must be above 0 Hz, is {rate!r}; 60 to 1000 is usual")


def paced(rate: float, duration: Optional[float], wait: Callable[[float], bool]) -> Iterator[float]:
    """Yields the time [s] since the first call, `rate` times a second, for `duration` [s] or until wait(seconds) says that all is over. Work
    that takes longer than a period delays the next one; none is made up for."""
    require_rate(rate)
    begin = due = clock.monotonic()
    while duration is None or due - begin < duration:
        yield due - begin
        due = max(due + 1.0 / rate, clock.monotonic())
        if wait(max(0.0, due - clock.monotonic())):
            return
