"""Hands, their recordings and followers for asyncio. A blocking call has a thread of the event loop's pool for its time; ticks are fetched in batches by the loop
itself.

    async with feltwire.aio.join(server.address, "plane", device="simulated:path=press", duration=3) as hand:
        async for tick in hand:
            ...
"""
from __future__ import annotations

import asyncio
import functools
from typing import Any, AsyncIterator, Callable, Generator, Generic, List, Optional, Sequence, Tuple, TypeVar

from . import abi
from . import follower as followers
from . import hand as blocking
from .errors import Error
from .pacing import require_rate
from .values import Path

_PERIOD = 0.02  # [s] between two looks at a hand
_Handle = TypeVar("_Handle", "Hand", "Follower", "Recorder")
_Self = TypeVar("_Self", bound="_Closed")


class Joining(Generic[_Handle]):
    """A call that goes on. `await` it for the Hand, Follower or Recorder, or use it with `async with`, which also closes it."""

    def __init__(self, opening: Callable[[], Any], kind: Callable[[Any], _Handle]):
        self._opening, self._kind = opening, kind
        self._opened: Optional[_Handle] = None

    def __await__(self) -> Generator[Any, None, _Handle]:
        return self._run().__await__()

    async def _run(self) -> _Handle:
        joining = asyncio.get_running_loop().run_in_executor(None, self._opening)
        try:
            return self._kind(await asyncio.shield(joining))
        except asyncio.CancelledError:
            # The library cannot break off a join: what it opens is closed when it comes.
            joining.add_done_callback(_close_late)
            raise

    async def __aenter__(self) -> _Handle:
        self._opened = await self._run()
        return self._opened

    async def __aexit__(self, kind: Any, *_: object) -> None:
        if self._opened is not None:
            await self._opened.__aexit__(kind)


def _close_late(joining: "asyncio.Future[Any]") -> None:
    if not joining.cancelled() and joining.exception() is None:
        joining.get_loop().run_in_executor(None, joining.result().__exit__, Error)


def join(server: str, scene: str, **options: Any) -> Joining[Hand]:
    """As feltwire.join(), for `async with join(...) as hand` or `hand = await join(...)`. Errors come as there."""
    return Joining(functools.partial(blocking.join, server, scene, **options), Hand)


def follow(server: str, scene: str, **options: Any) -> Joining[Follower]:
    """As feltwire.follow(), for `async with follow(...) as follower` or `follower = await follow(...)`. Errors come as there."""
    return Joining(functools.partial(followers.follow, server, scene, **options), Follower)


class _Closed:
    """What all share: each is closed without holding up the loop. `_blocking` is the one of feltwire."""

    def __init__(self, blocking_one: Any):
        self._blocking, self._closing = blocking_one, False

    async def close(self) -> None:
        """As close() of the blocking one: ends the use, and raises its error. May be called again."""
        self._closing = True
        await asyncio.get_running_loop().run_in_executor(None, self._blocking.close)

    async def __aenter__(self: _Self) -> _Self:
        return self

    async def __aexit__(self, kind: Any, *_: object) -> None:
        try:
            await self.close()
        except Error:
            if kind is None:
                raise


class _Run(_Closed):
    """What a hand and a follower share."""

    def messages(self) -> List[str]:
        """Its messages since the last call."""
        return list(self._blocking.messages())

    def _ended(self) -> bool:
        if self._closing:  # A thread closes it, and this one must not wait for it.
            raise ValueError(f"the {self._blocking.NAME} is closed")
        return bool(self._blocking.wait(0.0))

    async def wait(self, timeout: Optional[float] = None) -> bool:
        """Waits until the run has ended, at most `timeout` [s]; None: without an end. Returns whether it has ended."""
        loop = asyncio.get_running_loop()
        end = None if timeout is None else loop.time() + timeout
        while not self._ended():
            if end is not None and loop.time() >= end:
                return False
            await asyncio.sleep(_PERIOD)
        return True


class Recorder(_Closed):
    """A feltwire.Recorder for asyncio, of Hand.record()."""

    async def mark(self, text: str) -> None:
        """As feltwire.Recorder.mark()."""
        await asyncio.get_running_loop().run_in_executor(None, self._blocking.mark, text)

    def state(self) -> abi.RecordingState:
        """As feltwire.Recorder.state(). Never waits."""
        state: abi.RecordingState = self._blocking.state()
        return state


class Hand(_Run):
    """A feltwire.Hand for asyncio. hand is the blocking one, session what the server granted."""

    def __init__(self, hand: blocking.Hand):
        super().__init__(hand)
        self.hand = hand
        self.session: abi.Session = hand.session

    def latest(self) -> Optional[abi.Tick]:
        """As feltwire.Hand.latest(). Never waits."""
        return self.hand.latest()

    def exchange(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0), buttons: int = 0,
                 deadman: bool = False, gripper: float = -1.0) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        """As feltwire.Hand.exchange(). Never waits."""
        return self.hand.exchange(position, orientation, buttons, deadman, gripper)

    def ticks(self) -> Any:
        """As feltwire.Hand.ticks(), also between those of batches(): each tick comes once. Never waits."""
        return self.hand.ticks()

    def record(self, file: Path, **options: Any) -> Joining[Recorder]:
        """As feltwire.Hand.record(), for `async with hand.record(file) as recorder` or `recorder = await hand.record(file)`."""
        return Joining(functools.partial(self.hand.record, file, **options), Recorder)

    def why_no_force(self) -> str:
        """As feltwire.Hand.why_no_force(). Never waits."""
        return self.hand.why_no_force()

    def stop(self) -> None:
        """Lets the force fade and ends the run. Does not wait."""
        self.hand.stop()

    async def batches(self, period: float = _PERIOD) -> AsyncIterator[Any]:
        """What feltwire.Hand.ticks() gives every `period` [s], without empty ones, until the run has ended."""
        ended = False
        while not ended:
            ended = self._ended()  # before the ticks, so that none is left
            ticks = self.hand.ticks()
            if len(ticks):
                yield ticks
            if not ended:
                await asyncio.sleep(period)

    async def __aiter__(self) -> AsyncIterator[Any]:
        """Every tick since the last one, until the run has ended: a row of NumPy's array, or a feltwire.abi.Tick without NumPy."""
        async for ticks in self.batches():
            for tick in ticks:
                yield tick


class Follower(_Run):
    """A feltwire.Follower for asyncio. follower is the blocking one."""

    def __init__(self, follower: followers.Follower):
        super().__init__(follower)
        self.follower = follower

    def exchange(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
                 **state: Any) -> Optional[abi.RobotTarget]:
        """As feltwire.Follower.exchange(). Never waits."""
        return self.follower.exchange(position, orientation, **state)

    def latest(self) -> Optional[abi.RobotTarget]:
        """As feltwire.Follower.latest(). Never waits."""
        return self.follower.latest()

    @property
    def state(self) -> str:
        """As feltwire.Follower.state."""
        return self.follower.state

    def stop(self) -> None:
        """Leaves the scene. The target brakes for 0.25 s, then exchange() returns None. Does not wait."""
        self.follower.stop()

    async def paced(self, rate: float, duration: Optional[float] = None) -> AsyncIterator[float]:
        """Yields the time [s] since the call, `rate` times a second, until the run has ended or for `duration` [s]. A loop that has other work
        is late by it; a robot that needs an even pace has a thread, and feltwire.Follower."""
        require_rate(rate)
        loop = asyncio.get_running_loop()
        begin = due = loop.time()
        while not self._ended() and (duration is None or due - begin < duration):
            yield due - begin
            due = max(due + 1.0 / rate, loop.time())
            await asyncio.sleep(max(0.0, due - loop.time()))
