"""A hand in a haptic scene, from Python.

    import feltwire

    with feltwire.serve("scenes/plane.json") as server:
        with server.join(path="press", duration=3) as hand:
            hand.wait()
            ticks = hand.ticks()          # every tick since it joined
    print(ticks["force"].max(axis=0))     # [N]

The hand's servo runs in libfeltwire.so, at 1 kHz and more, with the bound, the energy account and the limits of feltwire-client. Python
sets the target and reads the latest state; a Python program that pauses makes no tick late. Units are SI. docs/python.md is the
tutorial.
"""
from .hand import Error, Hand, Refused, ServerError, join
from .served import Server, serve

__all__ = ["Error", "Hand", "Refused", "Server", "ServerError", "join", "serve"]
