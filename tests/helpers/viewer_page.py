import base64

import cv2
import numpy as np
from browser import chromium


class ViewerPage:
    """A page of the browser; a context manager. Scripts reach the program's own names."""

    def __init__(self, size=(900, 600)):
        self.size, self.path = size, None
        self.requests, self.complaints = [], []

    def __enter__(self):
        self._browser = chromium("--enable-unsafe-swiftshader")
        browser = self._browser.__enter__()
        width, height = self.size
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.page.on("request", self._asked)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on(
            "console",
            lambda said: self.complaints.append(said.text) if said.type == "error" else None,
        )
        self._tools = self.page.context.new_cdp_session(self.page)
        return self

    def __exit__(self, *fault):
        return self._browser.__exit__(*fault)

    def open(self, path):
        self.path = path
        self.requests.clear()
        self.complaints.clear()
        self.page.goto(path.as_uri())
        self.wait(
            '!document.getElementById("message")'
            ' || document.getElementById("message").textContent !== "Loading"'
        )

    def _asked(self, request):
        if request.url != self.path.as_uri() and not request.url.startswith("data:"):
            self.requests.append(request.url)

    def run(self, script):
        done = self._tools.send(
            "Runtime.evaluate", {"expression": script, "returnByValue": True, "awaitPromise": True}
        )
        assert "exceptionDetails" not in done, done["exceptionDetails"]
        return done["result"].get("value")

    def wait(self, condition, seconds=60):
        for _ in range(round(seconds / 0.05)):
            if self.run(condition):
                return
            self.page.wait_for_timeout(50)
        raise TimeoutError(condition)

    def picture(self):
        """Return the page as (h, w, 3) int sRGB array."""
        data = self._tools.send("Page.captureScreenshot", {"format": "png"})["data"]
        image = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)
        return image[..., ::-1].astype(int)
