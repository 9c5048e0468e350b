"""Hands for asyncio. A blocking call has a thread of the event loop's pool for its time; ticks are fetched in batches by the loop itself.

    async with feltwire.aio.join(server.address, "plane", path="press", duration=3) as hand:
        async for tick in hand:
            ...
"""
from __future__ import annotations

import asyncio
import functools
from typing import Any, AsyncIterator, Generator, List, Optional, Sequence, Tuple

from . import abi
from . import hand as blocking
from .errors import Error

_PERIOD = 0.02  # [s] between two looks at a hand


class Joining:
    """A join that goes on. `await` it for the Hand, or use it with `async with`, which also closes the hand."""

    def __init__(self, server: str, scene: str, options: Any):
        self._join = functools.partial(blocking.join, server, scene, **options)
        self._hand: Optional[Hand] = None

    def __await__(self) -> Generator[Any, None, "Hand"]:
        return self._run().__await__()

    async def _run(self) -> "Hand":
        joining = asyncio.get_running_loop().run_in_executor(None, self._join)
        try:
            return Hand(await asyncio.shield(joining))
        except asyncio.CancelledError:
            # The library cannot break off a join: its hand is closed when it comes.
            joining.add_done_callback(_close_late)
            raise

    async def __aenter__(self) -> "Hand":
        self._hand = await self._run()
        return self._hand

    async def __aexit__(self, kind: Any, *_: object) -> None:
        if self._hand is not None:
            await self._hand.__aexit__(kind)


def _close_late(joining: "asyncio.Future[blocking.Hand]") -> None:
    if not joining.cancelled() and joining.exception() is None:
        joining.get_loop().run_in_executor(None, joining.result().__exit__, Error)


def join(server: str, scene: str, **options: Any) -> Joining:
    """As feltwire.join(), for `async with join(...) as hand` or `hand = await join(...)`. Errors come as there."""
    return Joining(server, scene, options)


class Hand:
    """A feltwire.Hand for asyncio. hand is the blocking one, session what the server granted."""

    def __init__(self, hand: blocking.Hand):
        self.hand = hand
        self.session: abi.Session = hand.session
        self._closing = False

    def latest(self) -> Optional[abi.Tick]:
        """As feltwire.Hand.latest(). Never waits."""
        return self.hand.latest()

    def exchange(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0), buttons: int = 0,
                 deadman: bool = False) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        """As feltwire.Hand.exchange(). Never waits."""
        return self.hand.exchange(position, orientation, buttons, deadman)

    def why_no_force(self) -> str:
        """As feltwire.Hand.why_no_force(). Never waits."""
        return self.hand.why_no_force()

    def messages(self) -> List[str]:
        """As feltwire.Hand.messages()."""
        return self.hand.messages()

    def stop(self) -> None:
        """Lets the force fade and ends the run. Does not wait."""
        self.hand.stop()

    def _ended(self) -> bool:
        if self._closing:  # A thread closes it, and this one must not wait for it.
            raise ValueError("the hand is closed")
        return self.hand.wait(0.0)

    async def wait(self, timeout: Optional[float] = None) -> bool:
        """Waits until the run has ended, at most `timeout` [s]; None: without an end. Returns whether it has ended."""
        loop = asyncio.get_running_loop()
        end = None if timeout is None else loop.time() + timeout
        while not self._ended():
            if end is not None and loop.time() >= end:
                return False
            await asyncio.sleep(_PERIOD)
        return True

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

    async def close(self) -> None:
        """Ends the run, and leaves the scene. Raises Error if an error had ended the run. May be called again."""
        self._closing = True
        await asyncio.get_running_loop().run_in_executor(None, self.hand.close)

    async def __aenter__(self) -> "Hand":
        return self

    async def __aexit__(self, kind: Any, *_: object) -> None:
        try:
            await self.close()
        except Error:
            if kind is None:
                raise
