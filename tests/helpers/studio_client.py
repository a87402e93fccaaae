import http.client
import json

TOKEN = "a-token-of-the-tests"


class StudioClient:
    """Asks the server at a port; `headers` are of the last answer."""

    def __init__(self, port):
        self.port = port

    def ask(self, method, path, body=None, *, token=TOKEN, **headers):
        """Return the status and the body of an answer (parsed where it is JSON)."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=90)
        sent = json.dumps(body).encode() if isinstance(body, dict) else body
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(method, f"/{token}/{path}", body=sent, headers=named)
        answer = connection.getresponse()
        content = answer.read()
        self.headers = dict(answer.getheaders())
        connection.close()
        kind = answer.getheader("content-type") or ""
        return answer.status, json.loads(content) if "json" in kind else content
