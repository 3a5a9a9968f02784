# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium, driven through its DevTools protocol with the standard library alone."""
import base64
import json
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import urllib.parse


# Visible texts whose colour has less than this contrast over the backgrounds behind it, by WCAG 2.1 (1.4.3), with opacities and
# the filter of the page.
LEAST_CONTRAST = 4.5
FAINT_TEXTS = """(least => {
  const canvas = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const once = make => (known => key => known.get(key) ?? known.set(key, make(key)).get(key))(new Map());
  canvas.filter = getComputedStyle(document.documentElement).filter;
  const seen = once(colour => {  // as the page's filter shows it
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data].slice(0, 3);
  });
  const numbers = colour => (colour.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const over = ([r, g, b, a = 1], under, opacity = 1) => [r, g, b].map((v, i) => v * a * opacity + under[i] * (1 - a * opacity));
  const luminance = colour => seen(`rgb(${colour.map(Math.round)})`).map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = once(element => {  // the colour behind it, and the opacity of all around it
    const style = getComputedStyle(element), [behind, opacity] = element.parentElement ? ground(element.parentElement) : [[255, 255, 255], 1];
    return [over(numbers(style.backgroundColor), behind), opacity * style.opacity];
  });
  const faint = new Set(), texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text; (text = texts.nextNode());) {
    const element = text.parentElement, style = getComputedStyle(element);
    if (!text.data.trim() || !element.getClientRects().length || style.visibility !== 'visible' || element.closest('script, style, .headerlink')) continue;
    const [behind, opacity] = ground(element);
    const two = [over(numbers(element.closest('svg') ? style.fill : style.color), behind, opacity), behind].map(luminance).sort((a, b) => b - a);
    const contrast = (two[0] + 0.05) / (two[1] + 0.05);
    if (opacity > 0 && contrast < least) faint.add(`${element.tagName} "${text.data.trim().slice(0, 30)}": contrast ${contrast.toFixed(2)}`);
  }
  return [...faint];
})"""


class BrowserError(Exception):
    pass


class Socket:
    """A client of one WebSocket (RFC 6455); messages are JSON."""

    def __init__(self, url, seconds):
        parts = urllib.parse.urlsplit(url)
        self.tcp = socket.create_connection((parts.hostname, parts.port), timeout=seconds)
        self.buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        self.tcp.sendall((f"GET {parts.path} HTTP/1.1\r\nHost: {parts.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                          f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.buffer:
            self.read()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise BrowserError(head.decode(errors="replace"))

    def read(self):
        data = self.tcp.recv(1 << 16)
        if not data:
            raise BrowserError("the browser closed its connection")
        self.buffer += data

    def take(self, count):
        while len(self.buffer) < count:
            self.read()
        out, self.buffer = self.buffer[:count], self.buffer[count:]
        return out

    def send(self, message):
        data = json.dumps(message).encode()
        size = len(data)
        length = bytes([0x80 | size]) if size < 126 else b"\xfe" + struct.pack(">H", size) if size < 65536 else b"\xff" + struct.pack(">Q", size)
        mask = os.urandom(4)
        self.tcp.sendall(b"\x81" + length + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))

    def receive(self):
        text = b""
        while True:
            first, second = self.take(2)
            size = second & 0x7f
            if size == 126:
                size, = struct.unpack(">H", self.take(2))
            elif size == 127:
                size, = struct.unpack(">Q", self.take(8))
            text += self.take(size)
            if first & 0x0f in (0, 1, 2) and first & 0x80:
                return json.loads(text)


class Browser:
    """One page of a Chromium that ends with this object. `problems` are errors of its console."""

    def __init__(self, seconds=60):
        program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
        if not program:
            raise BrowserError("no Chromium: apt-get install chromium")
        self.profile = tempfile.mkdtemp(prefix="tactel-browser-")
        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--hide-scrollbars",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-port=0",
             f"--user-data-dir={self.profile}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.number, self.problems, self.requests = 0, [], []
        try:
            self.socket = Socket(self.page_address(), seconds)
        except BaseException:
            self.close()
            raise
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")

    def page_address(self):
        for line in self.process.stderr:
            if line.startswith("DevTools listening on "):
                url = line.split()[-1]
                break
        else:
            raise BrowserError("Chromium did not start")
        browser = Socket(url, 60)
        browser.send({"id": 1, "method": "Target.getTargets"})
        targets = browser.receive()["result"]["targetInfos"]
        page = next(t["targetId"] for t in targets if t["type"] == "page")
        return url.split("/devtools/")[0] + "/devtools/page/" + page

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stderr.close()
        shutil.rmtree(self.profile, ignore_errors=True)

    def note(self, message):
        kind, what = message.get("method"), message.get("params", {})
        if kind == "Runtime.exceptionThrown":
            details = what["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description", details["text"]))
        elif kind == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.problems.append(" ".join(str(a.get("value", a.get("description"))) for a in what["args"]))
        elif kind == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            self.problems.append(what["entry"]["text"])
        elif kind == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send({"id": self.number, "method": method, "params": parameters})
        while True:
            message = self.socket.receive()
            if message.get("id") == self.number:
                if "error" in message:
                    raise BrowserError(f"{method}: {message['error']['message']}")
                return message["result"]
            self.note(message)

    def open(self, path, width=1280, height=900, dark=False, sharp=1):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=sharp, mobile=width < 600)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.call("Page.navigate", url=path if "://" in str(path) else pathlib.Path(path).resolve().as_uri())
        while self.run("document.readyState") != "complete":
            time.sleep(0.01)

    def run(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise BrowserError(details.get("exception", {}).get("description", details["text"]))
        return result["result"].get("value")

    def faint_texts(self):
        self.run("document.head.append(Object.assign(document.createElement('style'), {textContent: '* { transition: none !important }'}))")
        return self.run(f"{FAINT_TEXTS}({LEAST_CONTRAST})")

    def picture(self, selector=None, whole=True, kind="png", quality=90):
        """Bytes of a picture of the page, or of one element; "webp" is smaller."""
        if selector:
            box = self.run(f"(r => ({{x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height}}))(document.querySelector({json.dumps(selector)}).getBoundingClientRect())")
        else:
            box = {"x": 0, "y": 0, "width": self.run("innerWidth"), "height": self.run("document.documentElement.scrollHeight" if whole else "innerHeight")}
        shot = self.call("Page.captureScreenshot", format=kind, captureBeyondViewport=True, clip={**box, "scale": 1},
                         **({} if kind == "png" else {"quality": quality}))
        return base64.b64decode(shot["data"])

    def pdf(self):
        return base64.b64decode(self.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"])
