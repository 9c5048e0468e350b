"""Hands, their recordings, followers, observers and admins for asyncio. A blocking call has a thread of the event loop's pool for its time; ticks and
states are fetched by the loop itself.

    async with feltwire.aio.join(server.address, "plane", device="simulated:path=press", duration=3) as hand:
        async for tick in hand:
            ...
"""
from __future__ import annotations

import asyncio
import functools
from typing import Any, AsyncIterator, Callable, Dict, Generator, Generic, List, Optional, Sequence, Tuple, TypeVar, Union

from . import abi, admins
from . import follower as followers
from . import hand as blocking
from . import observer as observers
from .errors import Error
from .pacing import require_rate
from .values import Path

_PERIOD = 0.02  # [s] between two looks at a hand
_VIEW = 0.005  # [s] between two looks at an observer, whose views come every 10 ms
_Handle = TypeVar("_Handle", "Hand", "Follower", "Recorder", "Observer", "Admin")
_Self = TypeVar("_Self", bound="_Closed")


class Joining(Generic[_Handle]):
    """A call that goes on. `await` it for the Hand, Follower, Recorder, Observer or Admin, or use it with `async with`, which also closes it."""

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


def observe(server: str, scene: str, **options: Any) -> Joining[Observer]:
    """As feltwire.observe(), for `async with observe(...) as observer` or `observer = await observe(...)`. Errors come as there."""
    return Joining(functools.partial(observers.observe, server, scene, **options), Observer)


def admin(server: str, **options: Any) -> Joining[Admin]:
    """As feltwire.admin(), for `async with admin(...) as one` or `one = await admin(...)`. Errors come as there."""
    return Joining(functools.partial(admins.admin, server, **options), Admin)


class _Closed:
    """What all share: each is closed without holding up the loop. `_blocking` is the one of feltwire."""

    def __init__(self, blocking_one: Any):
        self._blocking, self._closing = blocking_one, False

    async def close(self) -> None:
        """As close() of the blocking one: ends the use, and raises its error. May be called again."""
        self._closing = True
        await asyncio.get_running_loop().run_in_executor(None, self._blocking.close)

    def _require_open(self) -> None:
        if self._closing:  # A thread closes it, and this one must not wait for it.
            raise ValueError(f"the {self._blocking.NAME} is closed")

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
        self._require_open()
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

    def step(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0), buttons: int = 0,
             deadman: bool = False, gripper: float = -1.0) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        """As feltwire.Hand.step(). The loop waits for the tick meanwhile."""
        return self.hand.step(position, orientation, buttons, deadman, gripper)

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


class Observer(_Closed):
    """A feltwire.Observer for asyncio. observer is the blocking one. `async for state in observer` gives each newer state."""

    def __init__(self, observer: observers.Observer):
        super().__init__(observer)
        self.observer = observer

    def latest(self) -> Optional[abi.SceneState]:
        """As feltwire.Observer.latest(). Never waits."""
        state: Optional[abi.SceneState] = self.observer.latest()
        return state

    def hands(self) -> Any:
        """As feltwire.Observer.hands(). Never waits."""
        return self.observer.hands()

    def bodies(self) -> Any:
        """As feltwire.Observer.bodies(). Never waits."""
        return self.observer.bodies()

    def name(self, number: int) -> Optional[str]:
        """As feltwire.Observer.name(). It asks the server for nothing, so it does not wait for it."""
        name: Optional[str] = self.observer.name(number)
        return name

    def messages(self) -> List[str]:
        """What happened to the session since the last call."""
        return list(self.observer.messages())

    async def wait(self, timeout: Optional[float] = None, after: Optional[int] = None) -> bool:
        """Waits for a state with a number greater than `after` (None: than that of the newest), at most `timeout` [s]; None: without an end. Returns
        whether there is one; False also where the observer has ended."""
        loop = asyncio.get_running_loop()
        end = None if timeout is None else loop.time() + timeout
        self._require_open()
        number = self.observer._number() if after is None else after
        while (result := self.observer._look(number, 0.0)) == abi.NOTHING:
            if end is not None and loop.time() >= end:
                return False
            await asyncio.sleep(_VIEW)
            self._require_open()
        return bool(result == abi.OK)

    async def __aiter__(self) -> AsyncIterator[abi.SceneState]:
        """Each newer state, until the observer has ended. Where the loop is slow, states between are left out."""
        number = 0
        while await self.wait(after=number):
            state = self.latest()
            if state is not None:
                number = state.number
                yield state


class Admin(_Closed):
    """A feltwire.Admin for asyncio. Each call has a thread of the event loop's pool until the server has answered; errors come as there."""

    async def _call(self, name: str, *arguments: Any, **options: Any) -> Any:
        self._require_open()
        return await asyncio.get_running_loop().run_in_executor(None, functools.partial(getattr(self._blocking, name), *arguments, **options))

    async def request(self, *words: Any) -> Any:
        """As feltwire.Admin.request()."""
        return await self._call("request", *words)

    async def scenes(self) -> List[Dict[str, Any]]:
        """As feltwire.Admin.scenes()."""
        found: List[Dict[str, Any]] = await self._call("scenes")
        return found

    async def sessions(self, scene: Optional[str] = None) -> List[Dict[str, Any]]:
        """As feltwire.Admin.sessions()."""
        found: List[Dict[str, Any]] = await self._call("sessions", scene)
        return found

    async def stats(self) -> Any:
        """As feltwire.Admin.stats()."""
        return await self._call("stats")

    async def set(self, **options: Any) -> Any:
        """As feltwire.Admin.set()."""
        return await self._call("set", **options)

    async def evict(self, session: Union[int, str], scene: Optional[str] = None) -> Any:
        """As feltwire.Admin.evict()."""
        return await self._call("evict", session, scene)

    async def reload(self, scene: str) -> Any:
        """As feltwire.Admin.reload()."""
        return await self._call("reload", scene)

    async def record(self, scene: Optional[str] = None) -> Any:
        """As feltwire.Admin.record()."""
        return await self._call("record", scene)
