#!/usr/bin/env python3
"""Makes the surface of an object softer while hands feel it, and evicts hands that lose too many datagrams.

    my_admin.py HOST:PORT SCENE OBJECT

It needs the Python package (docs/python.md), and a token of the role admin (docs/admin.md):

    export FELTWIRE_FINGERPRINT_FILE=fingerprint FELTWIRE_TOKEN_FILE=admin.token
"""
import sys

import feltwire

LARGEST_LOSS = 0.5  # share of a hand's samples
STIFFNESS = 300  # [N/m]


def main():
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    address, scene, thing = sys.argv[1:]
    with feltwire.admin(address) as admin:
        print(admin.set(scene=scene, object=thing, stiffness=STIFFNESS)["change"])
        for session in admin.sessions(scene):
            print(f"session {session['number']}: {session['client']}, role {session['role']}, delivered {session['delivered_j']:.4f} J")
            if (session["loss"] or 0.0) > LARGEST_LOSS:
                admin.evict(session["session"])


if __name__ == "__main__":
    try:
        main()
    except (ValueError, feltwire.Error) as error:
        raise SystemExit(f"my_admin: {error}") from None
