"""Pages that follow a daemon as in a browser and draw nothing: benchmarks.page_followers URL COUNT.

Each opens the page, takes whatever the daemon sends and acknowledges it. What they cost a fire
request is what the daemon does for its pages, on a host that has no browser to draw for.
"""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlencode

import httpx
import socketio

from benchmarks.page_served import KEY

ACK_S = 1.0
"""A browser acknowledges what it has drawn about as often."""
READY = "follows"


async def follow(url: str, taken: dict[str, int]) -> socketio.AsyncClient:
    """Open the page and follow it; `taken` counts the messages of each page."""
    async with httpx.AsyncClient(base_url=url, follow_redirects=True, timeout=60.0) as browser:
        page = (await browser.get(f"/?key={KEY}")).raise_for_status().text
        cookies = "; ".join(f"{one.name}={one.value}" for one in browser.cookies.jar)
    client = re.search(r"'client_id': '([^']+)'", page)
    following = re.search(r"'next_message_id': (\d+)", page)
    if client is None or following is None:
        raise RuntimeError("the page does not name its client")
    name, first = client[1], int(following[1])
    names = {key: uuid.uuid4().hex for key in ("document_id", "tab_id")}
    query = {"client_id": name, "next_message_id": first, "implicit_handshake": "true", **names}
    line, taken[name] = socketio.AsyncClient(), 0

    async def take(event: str, *_: object) -> None:
        taken[name] += event == "update"

    async def acknowledge() -> None:
        while line.connected:
            await asyncio.sleep(ACK_S)
            await line.emit("ack", {"client_id": name, "next_message_id": first + taken[name]})

    line.on("*", take)
    await line.connect(
        f"{url}?{urlencode(query)}",
        headers={"Cookie": cookies},
        transports=["websocket"],
        socketio_path="/_nicegui_ws/socket.io",
    )
    line.start_background_task(acknowledge)
    return line


async def main(url: str, count: int) -> None:
    """Follow until standard input ends; then print how many changes each page was sent."""
    taken: dict[str, int] = {}
    lines = [await follow(url, taken) for _ in range(count)]
    print(READY, flush=True)
    await asyncio.to_thread(sys.stdin.read)
    for line in lines:
        await line.disconnect()
    print(*taken.values(), flush=True)


@contextmanager
def followers(url: str, count: int) -> Iterator[None]:
    """Have so many pages follow the daemon for the time of the block, in a process of their own.

    Raises
    ------
    RuntimeError
        They could not be opened, or one of them was sent nothing.
    """
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.page_followers", url, str(count)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        if process.stdout is None or process.stdout.readline().strip() != READY:
            raise RuntimeError("pages without a browser could not be opened")
        yield
        printed, _ = process.communicate("", timeout=60)
    finally:
        process.kill()
        process.wait()
    changes = [int(each) for each in printed.split()]
    if len(changes) != count or min(changes) == 0:
        raise RuntimeError(f"of {count} pages not every one was sent changes: {changes}")


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2])))
