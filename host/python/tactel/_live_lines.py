# SPDX-License-Identifier: Apache-2.0
"""Lines of a pipe as they come, until its end or a signal."""

import os
import select
import signal
import time
import warnings

LONGEST = 1 << 20  # bytes of a line
PERIOD = 1.0  # s
PATIENCE = 0.5  # s after a signal, in which what writes the lines may end


class LiveLines:
    """Iterates over the lines of a descriptor, bytes; None where for a second there is none. A context manager, in which SIGINT, SIGTERM
    and SIGHUP end the iteration and nothing else; a SIGHUP that nohup ignores stays so. What comes within half a second of the signal is
    taken. A last line without its end is left out, with a warning: its last number may be cut."""

    def __init__(self, source):
        self._source, self.stopped = source, False

    def __enter__(self):
        os.fstat(self._source)  # that it is open: the pipe would take its number
        self._told, self._tell = os.pipe()
        os.set_blocking(self._tell, False)
        signals = [of for of in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if of != signal.SIGHUP or signal.getsignal(of) != signal.SIG_IGN]
        self._handlers = {of: signal.signal(of, lambda *_: None) for of in signals}
        self._wake = signal.set_wakeup_fd(self._tell)
        return self

    def __exit__(self, *_):
        signal.set_wakeup_fd(self._wake)
        for of, handler in self._handlers.items():
            signal.signal(of, handler)
        os.close(self._told), os.close(self._tell)

    def __iter__(self):
        rest, end = b"", float("inf")
        while (left := end - time.monotonic()) > 0:
            ready, _, _ = select.select([self._source] + [self._told] * (not self.stopped), [], [], min(PERIOD, left))
            if self._told in ready:
                self.stopped, end = True, time.monotonic() + PATIENCE
            if self._source in ready:
                data = os.read(self._source, 1 << 16)
                if not data:
                    break
                *whole, rest = (rest + data).split(b"\n")
                yield from whole
                rest = rest[:LONGEST + 1]  # too long, which its reader says at its end
            elif not ready:
                yield None
        if rest.strip():
            warnings.warn("the last line has no end, and is left out")
