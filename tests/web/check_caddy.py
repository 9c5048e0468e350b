#!/usr/bin/env python3
"""The live page behind Caddy, with the configuration in docs/live_page.md (behind_proxy.py).

usage: check_caddy.py BIN_FOLDER SOURCE_FOLDER
Exit status 77: skipped, there is no caddy.
"""

import os
import re
import shutil
import subprocess
import sys
import unittest

from behind_proxy import HOSTS, SOURCE, BehindProxy, every, once

CADDY = shutil.which("caddy")


class Caddy(BehindProxy, unittest.TestCase):
    unknown_host = 200  # an empty answer of its own

    @classmethod
    def run_proxy(cls):
        (text,) = re.findall(r"```caddy\n(.*?)```", (SOURCE / "docs/live_page.md").read_text(), re.DOTALL)
        text = every(text, "reverse_proxy 127.0.0.1:6760", f"reverse_proxy 127.0.0.1:{cls.web}", 2)
        for host in HOSTS:
            text = once(text, f"{host} {{\n", f"https://{host}:{cls.port} {{\n    bind 127.0.0.1\n    tls {cls.certificate} {cls.key}\n")
        # Without a port for HTTP, and without one for administration.
        (cls.folder / "Caddyfile").write_text("{\n    admin off\n    auto_https disable_redirects\n}\n" + text)
        errors = cls.stack.enter_context(cls.error_log.open("w"))
        return cls.start([CADDY, "run", "--config", cls.folder / "Caddyfile", "--adapter", "caddyfile"], stdin=subprocess.DEVNULL, stderr=errors,
                         env={**os.environ, "HOME": str(cls.folder), "XDG_DATA_HOME": str(cls.folder), "XDG_CONFIG_HOME": str(cls.folder)})


if __name__ == "__main__":
    if CADDY is None:
        print("skipped: there is no caddy (scripts/packages-check.txt)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
