#!/usr/bin/env python3
"""The live page behind nginx, with docs/nginx.conf (behind_proxy.py).

usage: check_nginx.py BIN_FOLDER SOURCE_FOLDER
Exit status 77: skipped, there is no nginx.
"""

import os
import shutil
import subprocess
import sys
import unittest

from behind_proxy import HOSTS, READ_TIMEOUT, SOURCE, BehindProxy, every, once

NGINX = shutil.which("nginx", path=os.environ.get("PATH", "") + ":/usr/sbin")


class Nginx(BehindProxy, unittest.TestCase):
    @classmethod
    def run_proxy(cls):
        text = (SOURCE / "docs/nginx.conf").read_text()
        text = every(text, "listen 443 ssl;", f"listen 127.0.0.1:{cls.port} ssl;", 2)
        text = every(text, "proxy_pass http://127.0.0.1:6760", f"proxy_pass http://127.0.0.1:{cls.web}", 2)
        text = every(text, "proxy_read_timeout 60s;", f"proxy_read_timeout {READ_TIMEOUT}s;", 2)
        for host in HOSTS:
            text = once(text, f"/etc/ssl/{host}.pem", str(cls.certificate))
            text = once(text, f"/etc/ssl/{host}.key", str(cls.key))
        (cls.folder / "site.conf").write_text(text)
        (cls.folder / "nginx.conf").write_text(f"""
daemon off;
master_process off;
pid {cls.folder}/nginx.pid;
error_log {cls.error_log};
events {{}}
http {{
    access_log {cls.folder}/access.log;
    client_body_temp_path {cls.folder}/body;
    proxy_temp_path {cls.folder}/proxy;
    fastcgi_temp_path {cls.folder}/fastcgi;
    uwsgi_temp_path {cls.folder}/uwsgi;
    scgi_temp_path {cls.folder}/scgi;
    include {cls.folder}/site.conf;
}}
""")
        return cls.start([NGINX, "-p", cls.folder, "-e", cls.error_log, "-c", cls.folder / "nginx.conf"], stdin=subprocess.DEVNULL,
                         stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    if NGINX is None:
        print("skipped: there is no nginx (scripts/packages-check.txt)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
