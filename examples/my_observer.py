#!/usr/bin/env python3
"""Prints where the hands of a scene are and what they feel, four times a second.

    my_observer.py HOST:PORT SCENE [SECONDS]

It needs the Python package (docs/python.md), and a token of the role observer or any other that opens the scene:

    export FELTWIRE_FINGERPRINT_FILE=fingerprint FELTWIRE_TOKEN_FILE=observer.token
"""
import math
import sys

import feltwire

BETWEEN = 0.25  # [s]


def main():
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    until = float(sys.argv[3]) if len(sys.argv) == 4 else math.inf
    shown = 0.0
    with feltwire.observe(sys.argv[1], sys.argv[2], name="my_observer") as observer:
        for state in observer:
            for message in observer.messages():
                print(message, file=sys.stderr)
            if state.time < shown:
                continue
            shown = state.time + BETWEEN
            print(f"{state.time:.2f} s, {state.hands} hands, {state.bodies} bodies", flush=True)
            for hand in observer.hands():
                x, y, z = hand["position"] if hasattr(hand, "dtype") else hand.position
                force = hand["force"] if hasattr(hand, "dtype") else hand.force
                number = int(hand["number"]) if hasattr(hand, "dtype") else hand.number
                print(f"  {number} {observer.name(number) or '?'}: at {x:.4f} {y:.4f} {z:.4f} m, {math.dist(force, (0, 0, 0)):.2f} N",
                      flush=True)
            if state.time > until:
                return


if __name__ == "__main__":
    try:
        main()
    except (ValueError, feltwire.Error) as error:
        raise SystemExit(f"my_observer: {error}") from None
