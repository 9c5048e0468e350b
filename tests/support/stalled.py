"""The words of a client that the machine left standing. A busy machine without real-time scheduling does so, and a test repeats such a run."""

MOST_STALLS = 3
STALLED = ("it stood still for the hold time", "the servo loop broke off", "in a tick that held its force for")


def stalled(said):
    """Whether the output of a client tells of a stall."""
    return any(words in said for words in STALLED)
