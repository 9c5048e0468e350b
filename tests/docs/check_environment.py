#!/usr/bin/env python3
"""An option on the command line drops from the environment what it excludes, in every program.

Each program is run with one option of a group whose options exclude each other, and ends for a reason of its own: nothing listens at the
port that it is told, or a file is missing. With all others of the group in the environment it must end likewise, with the same words. The pairs of
feltwire-client are in tests/client/app/rival_options_test.cpp.

Each program has variables of its own. A misspelled one, and one with the name of before, ends it with the right name. An option that ends the
program has no variable: FELTWIRE_VERSION in a container's environment would end every program. An empty variable is refused, and so is an empty value.
No error shows a token. A number is decimal.

usage: check_environment.py BIN_FOLDER SOURCE_FOLDER
"""

import os
import pathlib
import socket
import subprocess
import sys
import tempfile


SECRET = "fw_0123456789ab_no_such_token"


def run(command, environment, home):
    clean = {name: value for name, value in os.environ.items() if not name.startswith("FELTWIRE_")}
    done = subprocess.run([str(word) for word in command], env={**clean, "HOME": str(home), **environment}, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False)
    return done.returncode, done.stdout


def variable(option, program=None):
    """The variable of an option: of all programs that join a server, or of one ("feltwire-server")."""
    own = program.removeprefix("feltwire-").upper() + "_" if program else ""
    return f"FELTWIRE_{own}" + option.strip("-").upper().replace("-", "_")


def groups(folder, source, place):
    """(command, options that exclude each other, further options that one of them excludes)"""
    fingerprint = folder / "fingerprint"
    fingerprint.write_text("ab" * 32 + "\n")
    token = folder / "token"
    token.write_text("fw_of_a_test\n")
    token.chmod(0o600)
    authority = folder / "ca.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout",
                    str(folder / "key.pem"), "-out", str(authority), "-days", "2", "-subj", "/CN=localhost"],
                   check=True, stderr=subprocess.DEVNULL)
    trust = {"--fingerprint": "cd" * 32, "--fingerprint-file": fingerprint, "--ca": authority}
    access = ["--connect", place, "--token-file", token]
    follower = ["feltwire-follower", *access, "--scene", "seat", "--reconnect", "0"]
    point, arm = source / "scenes/teleoperation/surroundings.json", source / "scenes/arm/table.xml"
    yield ["feltwire-client", *access, "--scene", "room"], trust, {}
    yield ["feltwire-client", *access, "--list"], trust, {}
    for words in (["sessions"], ["reload", "room"], ["evict", "1"], ["record"], ["stats"], ["set", "--gravity", "0,0,-1"]):
        yield ["feltwire-client", "admin", *words, *access], trust, {}
    yield [*follower, "--surroundings", point], trust, {}
    yield [*follower, "--fingerprint", "cd" * 32], {"--surroundings": point, "--arm": arm}, {"--socket": folder / "socket"}
    yield ["feltwire-view", *access, "--scene", folder / "missing.json", "--web", "0"], trust, {}


def refused_values():
    """(program, further words, value, part of the error). Each was read as another value, and the last ones ended with an error of CLI11."""
    empty, decimal, negative = "is empty; leave it out", "must be a decimal number", "must be 0 or more, is -1"
    yield "feltwire-server", "--port", "06720", decimal
    yield "feltwire-server", "--port", "0x1a40", decimal
    yield "feltwire-server", "--record", "", empty
    yield "feltwire-server", "--record=", "--demo", empty
    yield "feltwire-view", "--web", "", empty
    yield "feltwire-client", "--name", "", empty
    yield "feltwire-client", "--rate", "0x3e8", decimal
    yield "feltwire-client", "--token-file=", "token", empty
    yield "feltwire-client", "devices", "--root", "", empty
    yield "feltwire-client", "devices", "--rate", "simulated", "--seconds", "nan", "must be a number, is nan"
    yield "feltwire-follower", "--name", "", empty
    yield "feltwire-follower", "--duratoin", "1", "did you mean --duration?"
    yield "feltwire-lab", "bound", "--period", "0x1p-10", decimal
    yield "feltwire-soak", "--seed", "-1", negative
    yield "feltwire-soak", "--seed", "010", decimal
    yield "feltwire-soak", "--seed", "18446744073709551616", "is too large"
    yield "feltwire-soak", "--seconds", "nan", "must be a number, is nan"
    yield "feltwire-soak", "--clents", "3", "did you mean --clients?"
    yield "feltwire-netbench", "--rounds", "010", decimal
    yield "feltwire-netbench", "--seconds", "nan", "must be a number, is nan"
    yield "feltwire-netbench", "--round", "3", "did you mean --rounds?"


def main():
    programs, source = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    wrong, pairs = [], 0
    with tempfile.TemporaryDirectory() as name, socket.socket() as closed:
        folder = pathlib.Path(name)
        closed.bind(("127.0.0.1", 0))  # nobody listens there
        place = f"127.0.0.1:{closed.getsockname()[1]}"
        for words, options, others in groups(folder, source, place):
            command = [programs / words[0], *words[1:]]
            for option, value in options.items():
                rivals = {variable(other, words[0] if "--surroundings" in options else None): str(there)
                          for other, there in {**options, **others}.items() if other != option}
                alone = run([*command, option, value], {}, folder)
                beside = run([*command, option, value], rivals, folder)
                pairs += len(rivals)
                if "refused" not in alone[1] and "missing.json" not in alone[1]:
                    wrong.append(f"{words[0]} {option}: should end for a reason of its own, and says: {alone[1]}")
                if alone != beside:
                    wrong.append(f"{' '.join(map(str, words[:3]))} {option} with {', '.join(rivals)}:\n  alone: {alone}\n  beside: {beside}")
            if len(options) == 3:
                both = {variable("--ca"): str(options["--ca"]), variable("--fingerprint"): str(options["--fingerprint"])}
                status, said = run(command, both, folder)
                if status == 0 or "FELTWIRE_CA" not in said:
                    wrong.append(f"{words[0]}: two ways to trust in the environment: {status} {said}")
        ending = {variable(option): "true" for option in ("--version", "--help", "--list", "--check", "--health", "--explain")}
        # Program: another one, an option, and the same misspelled.
        programs_of = {"feltwire-client": ("feltwire-server", "--duration", "--duratoin"),
                       "feltwire-follower": ("feltwire-client", "--duration", "--duratoin"),
                       "feltwire-server": ("feltwire-client", "--log-level", "--log-levl"),
                       "feltwire-view": ("feltwire-server", "--log-level", "--log-levl")}
        for program, (other, option, misspelled) in programs_of.items():
            unknown = {**ending, variable("--record", other): "other.mcap", variable("--service-host", program): "10.0.0.1"}
            alone, beside = run([programs / program], {}, folder), run([programs / program], unknown, folder)
            if alone != beside:
                wrong.append(f"{program} with {', '.join(unknown)}:\n  alone: {alone}\n  beside: {beside}")
            for name in (variable(option), variable(misspelled, program)):
                status, said = run([programs / program], {name: "1"}, folder)
                if status == 0 or name not in said or variable(option, program) not in said:
                    wrong.append(f"{program} with {name}: {status} {said}")
            status, said = run([programs / program], {variable(option, program): ""}, folder)
            if status == 0 or f"{variable(option, program)} is empty" not in said:
                wrong.append(f"{program} with an empty {variable(option, program)}: {status} {said}")
        for words in (["feltwire-client", "--duration"], ["feltwire-client", "admin", "sessions", "--connect"], ["feltwire-client", "devices"],
                      ["feltwire-client", "identify", "--device"], ["feltwire-follower", "--duration"], ["feltwire-lab", "bound", "--period"],
                      ["feltwire-server", "--port"], ["feltwire-server", "token", "list"], ["feltwire-view", "--log-level"],
                      ["feltwire-bundle", folder / "a.tar.gz", "--lines"], ["feltwire-soak", "--seed"], ["feltwire-netbench", "--only"]):
            status, said = run([programs / words[0], *words[1:], SECRET], {}, folder)
            if status == 0 or SECRET in said or "fw_..." not in said:
                wrong.append(f"{' '.join(map(str, words))} with a token: {status} {said}")
        for *words, value, reason in refused_values():
            status, said = run([programs / words[0], *words[1:], value], {}, folder)
            if status != 2 or reason not in said or not said.startswith(words[0]) or "see --help" not in said:
                wrong.append(f"{' '.join(words)} {value}: {status} {said}")
    print("\n".join(wrong + [f"{pairs} pairs, {len(wrong)} wrong"]))
    return 1 if wrong or pairs < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
