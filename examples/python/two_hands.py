#!/usr/bin/env python3
"""Two hands in one scene, in one event loop: one presses, one taps. Prints what each feels five times a second.

    examples/python/two_hands.py [SECONDS]
"""
import asyncio
import pathlib
import sys

import feltwire

ROOM = pathlib.Path(__file__).resolve().parents[2] / "scenes/room.json"


async def feel(server: feltwire.Server, path: str, duration: float) -> float:
    """Moves a simulated hand along a path for `duration` [s]. Returns its largest force [N]."""
    largest = 0.0
    async with feltwire.aio.join(server.address, "room", fingerprint_file=server.fingerprint_file, token_file=server.token_file,
                                 name=path, device=f"simulated:path={path}", duration=duration, flight_recorder="off") as hand:
        async for ticks in hand.batches(period=0.2):
            forces = [tick["force"] if hasattr(tick, "dtype") else tick.force for tick in ticks]
            here = max(sum(one * one for one in force) ** 0.5 for force in forces)
            largest = max(largest, here)
            print(f"{path:6} {len(ticks):4} ticks, at most {here:.2f} N  {hand.why_no_force()}")
    return largest


async def run(duration: float) -> None:
    with feltwire.serve(ROOM) as server:
        one, other = await asyncio.gather(feel(server, "press", duration), feel(server, "taps", duration))
    print(f"largest forces: {one:.2f} N and {other:.2f} N")


if __name__ == "__main__":
    asyncio.run(run(float(sys.argv[1]) if len(sys.argv) > 1 else 2.0))
