"""The real programs, and a domain that nobody else on this host has."""

import os
import pathlib
import re
import select
import signal
import socket
import subprocess
import time

_SOURCE = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


def _constant(header, name):
    return int(re.search(rf"\b{name} = (\d+);", (_SOURCE / header).read_text())[1])


def _take(port):
    """A socket that has the port to itself; None where another has it."""
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        taken.bind(("", port))
        return taken
    except OSError:
        taken.close()
        return None


_claims = []


def own_domain():
    """As tests/support/test_domain.cpp does it, so that neither takes what the other has."""
    gain = _constant("common/dds/ports.h", "kPortsPerDomain")
    first = _constant("common/dds/ports.h", "kFirstPort")

    def nobody_in(number):
        discovery = _take(first + gain * number)
        if discovery:
            discovery.close()
        return discovery is not None

    for domain in range(1, _constant("common/dds/topics.h", "kMaxDomain")):
        claim = _take(first + gain * 2 * domain + gain - 1)
        if not claim:
            continue
        if nobody_in(2 * domain) and nobody_in(2 * domain + 1):
            _claims.append(claim)  # until this process ends
            return domain
        claim.close()
    raise RuntimeError("no --domain is free on this host for a test")


class Program:
    """A program of the build, which is told to end with its block: a station leaves its session then."""

    def __init__(self, name, *arguments):
        self.text = ""
        self.process = subprocess.Popen(
            [os.path.join(os.environ["PALPATE_PROGRAMS"], name), *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )
        os.set_blocking(self.process.stdout.fileno(), False)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.signal(signal.SIGTERM)
        try:
            self.ends(10)
        except subprocess.TimeoutExpired:
            pass
        self.kill()

    def says(self, words, seconds=60):
        until = time.monotonic() + seconds
        while words not in self.text:
            if time.monotonic() > until:
                return False
            select.select([self.process.stdout], [], [], 0.1)
            read = self.process.stdout.read()
            if read:
                self.text += read.decode(errors="replace")
            elif read == b"":
                return words in self.text
        return True

    def ends(self, seconds=60):
        """Its exit status, once it has ended."""
        out, _ = self.process.communicate(timeout=seconds)
        self.text += (out or b"").decode(errors="replace")
        return self.process.returncode

    def signal(self, number):
        self.process.send_signal(number)

    def kill(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process.stdout.close()


def server(domain, *arguments, scene="cube"):
    """palpate-server with a scene, over UDP, ready."""
    made = Program("palpate-server", scene, "--domain", domain, "--transport", "udp", "--realtime", "off", *arguments)
    if not made.says("ready"):
        made.kill()
        raise RuntimeError(made.text)
    return made


def station(domain, name, *arguments):
    """palpate-station with a simulated hand."""
    return Program("palpate-station", "--device", "simulated", "--scene", "cube", "--id", name, "--domain", domain,
                   "--transport", "udp", "--realtime", "off", *arguments)
