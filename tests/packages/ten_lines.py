import feltwire

with feltwire.serve("plane") as server:
    with server.join(device="simulated:path=press", duration=2, let_go_after=1, flight_recorder="off") as hand:
        hand.wait(60)
        ticks = hand.ticks()
force = [float(tick["force"][2]) if hasattr(tick, "dtype") else tick.force[2] for tick in ticks]
print(f"{feltwire.__file__}: {len(force)} ticks, largest force {max(force):.2f} N")
assert max(force) > 0.3

try:
    from matplotlib import pyplot
    pyplot.plot(force)
    pyplot.savefig("force.png")
except ImportError:
    pass
